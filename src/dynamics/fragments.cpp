// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/fragments.h"

#include "common/index.h"
#include "geometry/subdomain.h"
#include "parallel/agreement.h"
#include "parallel/exact_sum.h"
#include "parallel/node_field.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>
#include <vector>

namespace crackle::dynamics {

namespace {

/// Gathers three numbers of each node on the root, in the realization's numbering. Collective.
/// @param of_node of an owned node
template <class OfNode>
std::vector<Vector> gather(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                           const OfNode& of_node) {
  const auto owned = parallel::agree(group, [&] {
    std::vector<double> values;
    values.reserve(3 * index(subdomain.layout.n_owned));
    for (std::size_t n = 0; n < index(subdomain.layout.n_owned); ++n)
      for (const double value : Vector(of_node(n))) values.push_back(value);
    return values;
  });
  const auto values = parallel::gather_nodes(group, subdomain.layout, owned);
  return parallel::agree(group, [&] {
    std::vector<Vector> nodes(values.size() / 3);
    for (std::size_t i = 0; i < values.size(); ++i) nodes[i / 3][i % 3] = values[i];
    return nodes;
  });
}

/// Label, mass and whether it is frozen, of each node. As above.
std::vector<Vector> gather_labels(const parallel::Communicator& group, const fracture::BreakableBody& body,
                                  std::span<const std::int64_t> labels,
                                  std::span<const std::uint8_t> frozen) {
  return gather(group, body.subdomain(), [&](std::size_t n) {
    return Vector{static_cast<double>(labels[n]), body.operators().node_mass[n],
                  frozen.empty() ? 0.0 : static_cast<double>(frozen[n])};
  });
}

using Piece = std::vector<std::size_t>;

/// The nodes of each piece, ascending; pieces by their first node.
/// @param labels in the first component
std::vector<Piece> pieces_of(std::span<const Vector> labels) {
  std::vector<Piece> pieces;
  std::vector<std::size_t> place(labels.size());
  for (std::size_t n = 0; n < labels.size(); ++n) {
    const auto first = static_cast<std::size_t>(labels[n][0]);
    if (first == n) {
      place[n] = pieces.size();
      pieces.emplace_back();
    }
    pieces[place[first]].push_back(n);
  }
  return pieces;
}

/// @param term of a node
template <class Term>
double sum_over(const Piece& piece, const Term& term) {
  parallel::ExactSum sum;
  for (const auto node : piece) sum.add(term(node));
  return sum.value();
}

}  // namespace

Fragments find_fragments(const parallel::Communicator& group, const fracture::BreakableBody& body,
                         std::span<const std::int64_t> labels, std::span<const std::uint8_t> frozen,
                         std::span<const double> displacement, std::span<const double> velocity) {
  const geometry::Subdomain& subdomain = body.subdomain();
  const auto vector_of = [](std::span<const double> values, std::size_t n) {
    return values.empty() ? Vector{} : Vector{values[3 * n], values[3 * n + 1], values[3 * n + 2]};
  };
  const auto label = gather_labels(group, body, labels, frozen);
  const auto volume = gather(group, subdomain, [&](std::size_t n) {
    return Vector{body.operators().node_volume[n], 0, 0};
  });
  const auto place = gather(group, subdomain, [&](std::size_t n) { return Vector(subdomain.nodes[n]); });
  const auto moved = gather(group, subdomain, [&](std::size_t n) { return vector_of(displacement, n); });
  const auto speed = gather(group, subdomain, [&](std::size_t n) { return vector_of(velocity, n); });
  const auto mass = [&](std::size_t n) { return label[n][1]; };
  const auto fragment_of = [&](const Piece& nodes) {
    Fragment one;
    if (nodes.empty()) return one;
    one.first_node = static_cast<std::int64_t>(nodes.front());
    one.n_nodes = std::ssize(nodes);
    one.mass = sum_over(nodes, mass);
    one.volume = sum_over(nodes, [&](std::size_t n) { return volume[n][0]; });
    one.kinetic = sum_over(nodes, [&](std::size_t n) { return 0.5 * mass(n) * dot(speed[n], speed[n]); });
    one.is_frozen = label[nodes.front()][2] != 0;
    for (std::size_t i = 0; i < 3; ++i) {
      one.center[i] =
          sum_over(nodes, [&](std::size_t n) { return mass(n) * (place[n][i] + moved[n][i]); }) / one.mass;
      one.velocity[i] = sum_over(nodes, [&](std::size_t n) { return mass(n) * speed[n][i]; }) / one.mass;
      const auto [low, high] = std::ranges::minmax(nodes, {}, [&](std::size_t n) { return place[n][i]; });
      one.extent[i] = place[high][i] - place[low][i];
    }
    return one;
  };
  return parallel::agree(group, [&] {
    Fragments found;
    Piece all, dust;
    std::vector<Piece> pieces = pieces_of(label);
    for (const Piece& piece : pieces) {
      all.insert(all.end(), piece.begin(), piece.end());
      if (piece.size() == 1) dust.push_back(piece.front());
    }
    found.mass = sum_over(all, mass);
    found.dust = fragment_of(dust);
    found.dust.is_frozen = false;
    std::erase_if(pieces, [](const Piece& piece) { return piece.size() == 1; });
    for (const Piece& piece : pieces) found.pieces.push_back(fragment_of(piece));
    std::ranges::sort(found.pieces, {},
                      [](const Fragment& one) { return std::tuple(-one.mass, one.first_node); });
    found.of_node.assign(label.size(), -1);
    std::vector<std::int32_t> number(label.size(), -1);  // of the piece, by its first node
    for (std::size_t k = 0; k < found.pieces.size(); ++k)
      number[index(found.pieces[k].first_node)] = static_cast<std::int32_t>(k);
    for (std::size_t n = 0; n < label.size(); ++n)
      found.of_node[n] = number[static_cast<std::size_t>(label[n][0])];
    return found;
  });
}

FragmentCount count_fragments(const parallel::Communicator& group, const fracture::BreakableBody& body,
                              std::span<const std::int64_t> labels, std::span<const std::uint8_t> frozen,
                              double time) {
  const auto label = gather_labels(group, body, labels, frozen);
  const auto mass = [&](std::size_t n) { return label[n][1]; };
  return parallel::agree(group, [&] {
    FragmentCount count{.time = time};
    Piece dust, at_rest;
    for (const Piece& piece : pieces_of(label)) {
      if (label[piece.front()][2] != 0) {
        ++count.frozen;
        at_rest.insert(at_rest.end(), piece.begin(), piece.end());
      }
      if (piece.size() == 1) {
        dust.push_back(piece.front());
        continue;
      }
      ++count.number;
      const double of_piece = sum_over(piece, mass);
      count.second_mass = std::max(count.second_mass, std::min(of_piece, count.largest_mass));
      count.largest_mass = std::max(count.largest_mass, of_piece);
    }
    count.dust = std::ssize(dust);
    count.dust_mass = sum_over(dust, mass);
    count.frozen_mass = sum_over(at_rest, mass);
    return count;
  });
}

}  // namespace crackle::dynamics
