// SPDX-License-Identifier: GPL-3.0-or-later
// The source of the preconditioner's kernels; included once by the file of each instruction set.
#pragma once

#include "cell_kernels.h"
#include "kernels_body.h"

namespace {

using crackle::kernels::CellIntegers;
using crackle::kernels::CellKernels;
using crackle::kernels::CellNumbers;
using crackle::kernels::CornerShare;
using crackle::kernels::n_shares;
using crackle::kernels::NodeInCells;
using crackle::kernels::NodesInCells;

typedef float Float2 __attribute__((vector_size(8)));
/// Three numbers, and 0.
inline Float4 load_three(const float* from) {
  const Float2 two = ::load<Float2>(from);
  return __builtin_shufflevector(two, Float2{from[2], 0}, 0, 1, 2, 3);
}
inline void store_three(float* to, Float4 v) {
  store(to, __builtin_shufflevector(v, v, 0, 1));
  to[2] = v[2];
}
inline Double4 widened(Float4 v) {
  return __builtin_convertvector(v, Double4);
}
/// a x b of the first three numbers.
template <class Vector>
inline Vector cross_product(Vector a, Vector b) {
  const Vector a1 = __builtin_shufflevector(a, a, 1, 2, 0, 3), a2 = __builtin_shufflevector(a, a, 2, 0, 1, 3);
  const Vector b1 = __builtin_shufflevector(b, b, 1, 2, 0, 3), b2 = __builtin_shufflevector(b, b, 2, 0, 1, 3);
  return a1 * b2 - a2 * b1;
}

void set_displacements(NodeRecord<float>* nodes, std::size_t n, const float* u, double scale) {
  for (NodeRecord<float>* node = nodes; node != nodes + n; ++node, u += 3) {
    Int4 numbers = __builtin_convertvector(rounded(scale * widened(load_three(u))), Int4);
    numbers[3] = __builtin_bit_cast(std::int32_t, node->inverse_mass);
    store(node->displacement, numbers);
    store(node->force, Int4{});
  }
}

__int128 get_forces(const NodeRecord<float>* nodes, std::size_t n, double quantum, float* force) {
  Long4 high{}, low{};
  for (const NodeRecord<float>* node = nodes; node != nodes + n; ++node, force += 3) {
    const Int4 f = ::load<Int4>(node->force);
    const Long4 work = __builtin_convertvector(::load<Int4>(node->displacement), Long4) *
                       __builtin_convertvector(f, Long4);  // 0 in the last, like the force
    high += work >> 32;
    low += work & 0xffffffff;
    store_three(force, __builtin_convertvector(quantum * __builtin_convertvector(f, Double4), Float4));
  }
  return ((__int128)(high[0] + high[1] + high[2]) << 32) + (low[0] + low[1] + low[2]);
}

void add_loads(NodesInCells nodes, const float* load, double scale, CellNumbers* sums) {
  const NodeInCells* node = nodes.nodes;
  for (std::size_t g = 0; g < nodes.n_groups; ++g) {
    Double8 sum[n_shares] = {};
    for (const NodeInCells* last = node + nodes.groups[g].n_nodes; node != last; ++node) {
      const Double4 force = scale * widened(load_three(load + 3 * node->node));
      const Double4 moment = cross_product(widened(load_three(node->place)), force);
      const Double8 exact = __builtin_shufflevector(force, moment, 0, 1, 2, 3, 4, 5, 6, 7);
      const Double8 whole = (exact + shift) - shift;
      const Double4 weight = widened(::load<Float4>(node->weight));
      for (std::size_t s = 0; s < n_shares; ++s) sum[s] += weight[s] * whole;
    }
    for (std::size_t s = 0; s < n_shares; ++s) {
      double* of_cell = sums[nodes.groups[g].cell[s]].value;
      store(of_cell, ::load<Double8>(of_cell) + sum[s]);
    }
  }
}

std::int32_t add_motions(NodesInCells nodes, const float* load, const float* block, const CellNumbers* motion,
                         float* result) {
  Int4 largest{};
  const NodeInCells* node = nodes.nodes;
  for (std::size_t g = 0; g < nodes.n_groups; ++g) {
    Float8 of_cell[n_shares];
    for (std::size_t s = 0; s < n_shares; ++s)
      of_cell[s] = __builtin_convertvector(::load<Double8>(motion[nodes.groups[g].cell[s]].value), Float8);
    for (const NodeInCells* last = node + nodes.groups[g].n_nodes; node != last; ++node, block += 6) {
      Float8 c = node->weight[0] * of_cell[0];
      for (std::size_t s = 1; s < n_shares; ++s) c += node->weight[s] * of_cell[s];
      const Float4 translation = __builtin_shufflevector(c, c, 0, 1, 2, 3);
      const Float4 rotation = __builtin_shufflevector(c, c, 4, 5, 6, 7);
      const Float4 rigid = translation + cross_product(rotation, load_three(node->place));
      const float* r = load + 3 * node->node;
      const Float4 low = ::load<Float4>(block), high = ::load<Float4>(block + 2);
      const Float4 own = r[0] * __builtin_shufflevector(low, high, 0, 7, 6, 6) +
                         r[1] * __builtin_shufflevector(low, high, 7, 1, 3, 3) +
                         r[2] * __builtin_shufflevector(high, high, 2, 1, 0, 0);
      const Float4 z = own + rigid;
      store_three(result + 3 * node->node, z);
      const Int4 bits = (Int4)absolute(z) & Int4{-1, -1, -1, 0};
      largest = bits > largest ? bits : largest;
    }
  }
  std::int32_t of_all = 0;
  for (int i = 0; i < 3; ++i)
    if (largest[i] > of_all) of_all = largest[i];
  return of_all;
}

void find_strains(const CornerShare* shares, std::size_t n_shares, std::size_t n_cells,
                  const double (*stiffness)[6], CellNumbers* strain, CellNumbers* stress) {
  for (std::size_t k = 0; k < 6 * n_cells; ++k) store(strain[k].value, Double8{});
  for (const CornerShare* share = shares; share != shares + n_shares; ++share) {
    const double* g = share->gradient;
    const double* f = share->free;
    const double* a = share->arm;
    // The displacement due to each motion.
    const Double8 x = f[0] * Double8{1, 0, 0, 0, 0, a[2], -a[1], 0};
    const Double8 y = f[1] * Double8{0, 1, 0, 0, -a[2], 0, a[0], 0};
    const Double8 z = f[2] * Double8{0, 0, 1, 0, a[1], -a[0], 0, 0};
    const Double8 terms[6] = {g[0] * x,
                              g[1] * y,
                              g[2] * z,
                              0.5 * (g[1] * z + g[2] * y),
                              0.5 * (g[0] * z + g[2] * x),
                              0.5 * (g[0] * y + g[1] * x)};
    CellNumbers* of_cell = strain + 6 * share->cell;
    for (int k = 0; k < 6; ++k) store(of_cell[k].value, ::load<Double8>(of_cell[k].value) + terms[k]);
  }
  for (std::size_t c = 0; c < n_cells; ++c) {
    Double8 e[6];
    for (int k = 0; k < 6; ++k) e[k] = ::load<Double8>(strain[6 * c + k].value);
    for (int k = 0; k < 6; ++k) {
      Double8 sum = stiffness[k][0] * e[0];
      for (int l = 1; l < 6; ++l) sum += stiffness[k][l] * e[l];
      store(stress[6 * c + k].value, sum);
    }
  }
}

void add_energies(const CellNumbers* stress, const CellNumbers* strain, CellIntegers* block) {
  Double8 e[6];
  for (int k = 0; k < 6; ++k) e[k] = ::load<Double8>(strain[k].value);
  for (std::size_t m = 0; m < 6; ++m) {
    const std::size_t lane = m < 3 ? m : m + 1;
    Double8 sum = stress[0].value[lane] * e[0];
    for (int k = 1; k < 6; ++k) sum += stress[k].value[lane] * e[k];
    store(block[m].value, ::load<Long8>(block[m].value) + rounded(sum));
  }
}

constexpr CellKernels all_cell_kernels() {
  return {set_displacements, get_forces, add_loads, add_motions, find_strains, add_energies};
}

}  // namespace
