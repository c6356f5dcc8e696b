// SPDX-License-Identifier: GPL-3.0-or-later
// The kernels' source; included once by the file of each instruction set.
#pragma once

#include "kernels.h"
#include "lanes.h"

namespace {

using crackle::kernels::EdgeEnds;
using crackle::kernels::EdgeSkew;
using crackle::kernels::EdgeSymmetric;
using crackle::kernels::EnergyFactors;
using crackle::kernels::GeneralEdges;
using crackle::kernels::Integer;
using crackle::kernels::Kernels;
using crackle::kernels::Movement;
using crackle::kernels::NodeExtremes;
using crackle::kernels::NodeRecord;
using crackle::kernels::NodeUpdate;
using crackle::kernels::StressBound;
using crackle::kernels::TetrahedronGroup;
using crackle::kernels::Velocity;
using crackle::kernels::WideSum;

/// Number of lanes of a loop: the size of one register, but at least 4.
template <class Real>
constexpr int width() {
#if defined(__AVX512F__)
  return 8;
#elif defined(__AVX2__)
  return sizeof(Real) == 4 ? 8 : 4;
#else
  return 4;
#endif
}

template <class Vector>
inline Vector load(const void* from) {
  Vector v;
  __builtin_memcpy(&v, from, sizeof(Vector));
  return v;
}
template <class Vector>
inline void store(void* to, Vector v) {
  __builtin_memcpy(to, &v, sizeof(Vector));
}

/// Rows of nodal numbers (displacement or force): two nodes with 8 lanes, one with 4. Those without node
/// numbers are of the first two nodes or of the first.
template <class Real, int n>
struct Rows;

template <class Real>
struct Rows<Real, 4> {
  using One = typename Lanes<Real, 4>::Integer;
  using Vector = One;
  static Vector displacement(const NodeRecord<Real>* nodes, std::int32_t a, std::int32_t) {
    return load<One>(nodes[a].displacement);
  }
  static void add_force(NodeRecord<Real>* nodes, std::int32_t a, std::int32_t, Vector f) {
    store(nodes[a].force, load<One>(nodes[a].force) + f);
  }
  static Vector force(const NodeRecord<Real>* nodes) { return load<One>(nodes->force); }
  static void set_force(NodeRecord<Real>* nodes, Vector f) { store(nodes->force, f); }
  static void set_displacement(NodeRecord<Real>* nodes, Vector u) { store(nodes->displacement, u); }
  /// The fourth number of each node, four times.
  template <class V>
  static V fourth(V v) {
    return __builtin_shufflevector(v, v, 3, 3, 3, 3);
  }
};

template <class Real>
struct Rows<Real, 8> {
  using One = typename Lanes<Real, 4>::Integer;
  using Vector = typename Lanes<Real, 8>::Integer;
  static Vector displacement(const NodeRecord<Real>* nodes, std::int32_t a, std::int32_t b) {
    const One low = load<One>(nodes[a].displacement);
    const One high = load<One>(nodes[b].displacement);
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  }
  static void add_force(NodeRecord<Real>* nodes, std::int32_t a, std::int32_t b, Vector f) {
    store(nodes[a].force, load<One>(nodes[a].force) + __builtin_shufflevector(f, f, 0, 1, 2, 3));
    store(nodes[b].force, load<One>(nodes[b].force) + __builtin_shufflevector(f, f, 4, 5, 6, 7));
  }
  static Vector force(const NodeRecord<Real>* nodes) {
    return __builtin_shufflevector(load<One>(nodes[0].force), load<One>(nodes[1].force), 0, 1, 2, 3, 4, 5, 6,
                                   7);
  }
  static void set_force(NodeRecord<Real>* nodes, Vector f) {
    store(nodes[0].force, __builtin_shufflevector(f, f, 0, 1, 2, 3));
    store(nodes[1].force, __builtin_shufflevector(f, f, 4, 5, 6, 7));
  }
  static void set_displacement(NodeRecord<Real>* nodes, Vector u) {
    store(nodes[0].displacement, __builtin_shufflevector(u, u, 0, 1, 2, 3));
    store(nodes[1].displacement, __builtin_shufflevector(u, u, 4, 5, 6, 7));
  }
  template <class V>
  static V fourth(V v) {
    return __builtin_shufflevector(v, v, 3, 3, 3, 3, 7, 7, 7, 7);
  }
};

/// Tracks the largest magnitude met by a kernel, if enabled.
template <class Real, class RealVector, bool is_on>
struct Watch {
  RealVector largest{};
  void see(RealVector x, RealVector y, RealVector z) {
    if constexpr (is_on) largest = larger(largest, larger(absolute(x), larger(absolute(y), absolute(z))));
  }
  Real value() const {
    Real result = 0;
    for (unsigned i = 0; i < sizeof(RealVector) / sizeof(Real); ++i)
      if (largest[i] > result) result = largest[i];
    return result;
  }
};

/// S d and w x d for N edges.
template <class Real, int N>
struct Products {
  using R = typename Lanes<Real, N>::Real;
  R sx, sy, sz, wx, wy, wz;

  void set_symmetric(const Real s[6][8], int first, R x, R y, R z) {
    R k[6];
    for (int i = 0; i < 6; ++i) k[i] = load<R>(s[i] + first);
    sx = k[0] * x + k[5] * y + k[4] * z;
    sy = k[5] * x + k[1] * y + k[3] * z;
    sz = k[4] * x + k[3] * y + k[2] * z;
  }
  void set_skew(const Real w[3][8], int first, R x, R y, R z) {
    R k[3];
    for (int i = 0; i < 3; ++i) k[i] = load<R>(w[i] + first);
    wx = k[1] * z - k[2] * y;
    wy = k[2] * x - k[0] * z;
    wz = k[0] * y - k[1] * x;
  }
};

template <class Real, bool has_skew, bool watches>
inline Real add_owned_edges(const EdgeEnds* ends, const EdgeSymmetric<Real>* symmetric,
                            const EdgeSkew<Real>* skew, std::size_t n, NodeRecord<Real>* all_nodes) {
  constexpr int N = width<Real>();
  using R = typename Lanes<Real, N>::Real;
  using I = typename Lanes<Real, N>::Integer;
  using Row = Rows<Real, N>;
  Watch<Real, R, watches> watch;
  for (std::size_t i = 0; i < n; ++i) {
    NodeRecord<Real>* nodes = all_nodes + ends[i].owner;
    for (int half = 0; half < 8 / N; ++half) {
      const std::int16_t* b = ends[i].target + 4 * half;
      const std::int32_t a0 = half == 0 ? 0 : ends[i].second_owner;
      const std::int32_t a1 = ends[i].second_owner;
      const I from = Row::displacement(nodes, a0, a1);
      R difference[4];
      for (int k = 0; k < 4; ++k)
        difference[k] = to_real(Row::displacement(nodes, b[k], b[(4 + k) % N]) - from);
      R x, y, z;
      to_columns(difference, x, y, z);
      Products<Real, N> p;
      p.set_symmetric(symmetric[i].s, 4 * half, x, y, z);
      watch.see((Real)0.5 * x, (Real)0.5 * y, (Real)0.5 * z);
      I row[4];
      if constexpr (has_skew) {
        p.set_skew(skew[i].w, 4 * half, x, y, z);
        watch.see(absolute(p.sx) + absolute(p.wx), absolute(p.sy) + absolute(p.wy),
                  absolute(p.sz) + absolute(p.wz));
        to_rows(rounded(p.wx - p.sx), rounded(p.wy - p.sy), rounded(p.wz - p.sz), row);
        for (int k = 0; k < 4; ++k) Row::add_force(nodes, b[k], b[(4 + k) % N], row[k]);
        to_rows(rounded(p.sx + p.wx), rounded(p.sy + p.wy), rounded(p.sz + p.wz), row);
      } else {
        watch.see(p.sx, p.sy, p.sz);
        to_rows(rounded(p.sx), rounded(p.sy), rounded(p.sz), row);
        for (int k = 0; k < 4; ++k) Row::add_force(nodes, b[k], b[(4 + k) % N], -row[k]);
      }
      Row::add_force(nodes, a0, a1, (row[0] + row[1]) + (row[2] + row[3]));
    }
  }
  return watch.value();
}

template <class Real, bool watches>
Real add_symmetric_edges(const EdgeEnds* ends, const EdgeSymmetric<Real>* symmetric, std::size_t n,
                         NodeRecord<Real>* nodes) {
  return add_owned_edges<Real, false, watches>(ends, symmetric, nullptr, n, nodes);
}

template <class Real, bool watches>
Real add_skew_edges(const EdgeEnds* ends, const EdgeSymmetric<Real>* symmetric, const EdgeSkew<Real>* skew,
                    std::size_t n, NodeRecord<Real>* nodes) {
  return add_owned_edges<Real, true, watches>(ends, symmetric, skew, n, nodes);
}

template <class Real, bool watches>
Real add_general_edges(const GeneralEdges<Real>* edges, std::size_t n, NodeRecord<Real>* nodes) {
  constexpr int N = width<Real>();
  using R = typename Lanes<Real, N>::Real;
  using I = typename Lanes<Real, N>::Integer;
  using Row = Rows<Real, N>;
  Watch<Real, R, watches> watch;
  for (std::size_t i = 0; i < n; ++i) {
    for (int half = 0; half < 8 / N; ++half) {
      const std::int32_t* a = edges[i].first + 4 * half;
      const std::int32_t* b = edges[i].second + 4 * half;
      R difference[4];
      for (int k = 0; k < 4; ++k)
        difference[k] = to_real(Row::displacement(nodes, b[k], b[(4 + k) % N]) -
                                Row::displacement(nodes, a[k], a[(4 + k) % N]));
      R x, y, z;
      to_columns(difference, x, y, z);
      Products<Real, N> p;
      p.set_symmetric(edges[i].s, 4 * half, x, y, z);
      p.set_skew(edges[i].w, 4 * half, x, y, z);
      watch.see(absolute(p.sx) + absolute(p.wx), absolute(p.sy) + absolute(p.wy),
                absolute(p.sz) + absolute(p.wz));
      watch.see((Real)0.5 * x, (Real)0.5 * y, (Real)0.5 * z);
      I row[4];
      to_rows(rounded(p.sx + p.wx), rounded(p.sy + p.wy), rounded(p.sz + p.wz), row);
      for (int k = 0; k < 4; ++k) Row::add_force(nodes, a[k], a[(4 + k) % N], row[k]);
      to_rows(rounded(p.wx - p.sx), rounded(p.wy - p.sy), rounded(p.wz - p.sz), row);
      for (int k = 0; k < 4; ++k) Row::add_force(nodes, b[k], b[(4 + k) % N], row[k]);
    }
  }
  return watch.value();
}

/// Prefetches all cache lines of an object.
template <class Object>
inline void fetch(const Object* object) {
  constexpr std::size_t cache_line = 64;
  for (std::size_t i = 0; i < sizeof(Object); i += cache_line)
    __builtin_prefetch(reinterpret_cast<const char*>(object) + i);
}

/// The extremes met in an update by N lanes.
template <class Real, int N>
struct Extremes {
  using R = typename Lanes<Real, N>::Real;
  R force{};
  R high = R{} - (Real)__builtin_huge_val(), back = high;  // of the movement, and of its reverse

  void see(R way) {
    high = larger(high, way);
    back = larger(back, -way);
  }
};

/// Updates the nodes of one row of N lanes.
template <class Real, int N, bool has_kick, bool has_drift>
inline void update_row(NodeRecord<Real>* nodes, Velocity<Real>* velocity, Integer<Real> (*kept)[4],
                       const NodeUpdate<Real>& update, Extremes<Real, N>& extremes) {
  using R = typename Lanes<Real, N>::Real;
  using I = typename Lanes<Real, N>::Integer;
  using Row = Rows<Real, N>;
  // The next block follows in memory, but other work comes before it, so the processor does not foresee it.
  // An address beyond the arrays does no harm.
  constexpr std::size_t fetched_ahead = 64;
  for (int k = 0; k < N; k += 4) __builtin_prefetch(nodes + fetched_ahead + k / 4);
  __builtin_prefetch(velocity + fetched_ahead);
  if (has_drift && kept != nullptr) __builtin_prefetch(kept + fetched_ahead, 1);
  const I place = Row::displacement(nodes, 0, 1);
  I v = load<I>(velocity->value);
  if constexpr (has_kick) {
    const R force = to_real(Row::force(nodes));
    extremes.force = larger(extremes.force, absolute(force));
    v += rounded(force * (update.kick * Row::fourth((R)place)));
    store(velocity->value, v);
    if (!update.keeps_force) Row::set_force(nodes, I{});
  }
  if constexpr (has_drift) {
    if (kept != nullptr) store(kept, place);
    const R way = to_real(v) * update.drift;
    extremes.see(way);
    // The fourth number, the inverse mass, is unchanged, since that of the velocity is 0.
    Row::set_displacement(nodes, place + rounded(way));
  }
}

template <class Real, bool has_kick, bool has_drift>
NodeExtremes<Real> update_rows(NodeRecord<Real>* nodes, Velocity<Real>* velocity, std::size_t n,
                               const NodeUpdate<Real>& update) {
  constexpr int N = width<Real>();
  constexpr std::size_t nodes_per_row = N / 4;
  Extremes<Real, 4> extremes;
  const auto kept = [&](std::size_t i) { return update.kept == nullptr ? nullptr : update.kept + i; };
  std::size_t i = 0;
  if constexpr (nodes_per_row > 1) {
    Extremes<Real, N> of_rows;
    for (; i + nodes_per_row <= n; i += nodes_per_row)
      update_row<Real, N, has_kick, has_drift>(nodes + i, velocity + i, kept(i), update, of_rows);
    const auto larger_half = [](auto v) {
      return larger(__builtin_shufflevector(v, v, 0, 1, 2, 3), __builtin_shufflevector(v, v, 4, 5, 6, 7));
    };
    extremes = {larger_half(of_rows.force), larger_half(of_rows.high), larger_half(of_rows.back)};
  }
  for (; i < n; ++i)
    update_row<Real, 4, has_kick, has_drift>(nodes + i, velocity + i, kept(i), update, extremes);
  NodeExtremes<Real> result;
  result.force = 0;
  for (int k = 0; k < 4; ++k)
    if (extremes.force[k] > result.force) result.force = extremes.force[k];
  store(result.movement.low, -extremes.back);
  store(result.movement.high, extremes.high);
  return result;
}

template <class Real>
NodeExtremes<Real> update(NodeRecord<Real>* nodes, Velocity<Real>* velocity, std::size_t n,
                          const NodeUpdate<Real>& update) {
  if (!update.has_drift) return update_rows<Real, true, false>(nodes, velocity, n, update);
  if (!update.has_kick) return update_rows<Real, false, true>(nodes, velocity, n, update);
  return update_rows<Real, true, true>(nodes, velocity, n, update);
}

/// The strains of N tetrahedra of a group, scaled as their gradients.
template <class Real, int N>
struct Strains {
  using R = typename Lanes<Real, N>::Real;
  using I = typename Lanes<Real, N>::Integer;
  using Row = Rows<Real, N>;
  R e[6] = {};  // xx, yy, zz, 2 yz, 2 xz, 2 xy
  R trace;
  R largest{};  // difference of displacement

  Strains(const TetrahedronGroup<Real>& group, int first, const NodeRecord<Real>* nodes) {
    I origin[4];
    for (int k = 0; k < 4; ++k)
      origin[k] = Row::displacement(nodes, group.corner[0][first + k], group.corner[0][(4 + k) % 8]);
    for (int a = 1; a < 4; ++a) {
      const std::int32_t* corner = group.corner[a] + first;
      R difference[4];
      for (int k = 0; k < 4; ++k)
        difference[k] =
            to_real(Row::displacement(nodes, corner[k], group.corner[a][(4 + k) % 8]) - origin[k]);
      R x, y, z;
      to_columns(difference, x, y, z);
      largest = larger(largest, larger(absolute(x), larger(absolute(y), absolute(z))));
      const R bx = load<R>(group.gradient[3 * (a - 1)] + first);
      const R by = load<R>(group.gradient[3 * (a - 1) + 1] + first);
      const R bz = load<R>(group.gradient[3 * (a - 1) + 2] + first);
      e[0] += x * bx;
      e[1] += y * by;
      e[2] += z * bz;
      e[3] += y * bz + z * by;
      e[4] += x * bz + z * bx;
      e[5] += x * by + y * bx;
    }
    trace = e[0] + e[1] + e[2];
  }
};

template <class Real>
void check(const TetrahedronGroup<Real>* groups, const std::uint32_t* due, std::size_t n,
           const NodeRecord<Real>* nodes, StressBound<Real> stress, Real* room) {
  constexpr int N = width<Real>();
  using R = typename Lanes<Real, N>::Real;
  // Rounding errors: about 20 operations on terms smaller than sensitivity times the largest distance.
  constexpr Real slack = 128 * (sizeof(Real) == 4 ? 0x1p-24 : 0x1p-53);
  constexpr Real shortened = 1 - 0x1p-10;
  // The due groups are scattered over the memory.
  constexpr std::size_t fetched_ahead = 8;
  for (std::size_t i = 0; i < n && i < fetched_ahead; ++i) fetch(&groups[due[i]]);
  for (std::size_t i = 0; i < n; ++i) {
    if (i + fetched_ahead < n) fetch(&groups[due[i + fetched_ahead]]);
    const TetrahedronGroup<Real>& group = groups[due[i]];
    R least = R{} + (Real)1e30;
    for (int half = 0; half < 8 / N; ++half) {
      const Strains<Real, N> strains(group, 4 * half, nodes);
      const R* e = strains.e;
      const R trace = strains.trace;
      const R third = trace / 3;
      const R d0 = e[0] - third, d1 = e[1] - third, d2 = e[2] - third;
      const R j2 =
          (Real)0.5 * (d0 * d0 + d1 * d1 + d2 * d2) + (Real)0.25 * (e[3] * e[3] + e[4] * e[4] + e[5] * e[5]);
      const R sensitivity = load<R>(group.sensitivity + 4 * half);
      const R bound = larger(stress.trace[0] * trace, stress.trace[1] * trace) +
                      stress.deviator * square_root(j2) + slack * (strains.largest * sensitivity);
      const R margin = (Real)1 - bound;
      const R share = margin > 0 ? margin / sensitivity : R{};
      least = share < least ? share : least;
    }
    room[i] = shortened * smallest(least);
  }
}

template <class Real>
WideSum energy(const TetrahedronGroup<Real>* groups, const EnergyFactors<Real>* factors, std::size_t n,
               const NodeRecord<Real>* nodes) {
  constexpr int N = width<Real>();
  using R = typename Lanes<Real, N>::Real;
  using Wide = typename Lanes<double, N>::Real;
  using Long = typename Lanes<double, N>::Integer;
  constexpr double unit = 0x1p50;
  // Between two calls the groups leave the caches, and the loop takes as long as the memory.
  constexpr std::size_t fetched_ahead = 8;
  Long high{}, low{};
  for (std::size_t i = 0; i < n; ++i) {
    if (i + fetched_ahead < n) {
      fetch(&groups[i + fetched_ahead]);
      fetch(&factors[i + fetched_ahead]);
    }
    for (int half = 0; half < 8 / N; ++half) {
      const Strains<Real, N> strains(groups[i], 4 * half, nodes);
      const R* e = strains.e;
      const R square =
          (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) + (Real)0.5 * (e[3] * e[3] + e[4] * e[4] + e[5] * e[5]);
      const R term = load<R>(factors[i].trace + 4 * half) * (strains.trace * strains.trace) +
                     load<R>(factors[i].square + 4 * half) * square;
      const Wide energy = __builtin_convertvector(term, Wide);
      const Long units = rounded(energy * (1 / unit));
      high += units;
      low += rounded(energy - to_real(units) * unit);
    }
  }
  WideSum sum{0, 0};
  for (int k = 0; k < N; ++k) {
    sum.high += high[k];
    sum.low += low[k];
  }
  return sum;
}

template <class Real, bool watches>
constexpr Kernels<Real> all_kernels() {
  return {add_symmetric_edges<Real, watches>,
          add_skew_edges<Real, watches>,
          add_general_edges<Real, watches>,
          update<Real>,
          check<Real>,
          energy<Real>};
}

}  // namespace
