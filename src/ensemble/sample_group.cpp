// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/sample_group.h"

#include "crackle/common/index.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/message.h"

#include <stdexcept>

namespace crackle::ensemble {

namespace {

constexpr int share_tag = 1;
constexpr const char* sharing_stage = "sharing";

/// Calls work(array) for each array of a subdomain, in the order of transmission.
template <class Subdomain, class Work>
void for_each_array(Subdomain& part, const Work& work) {
  work(part.nodes);
  work(part.layout.number);
  work(part.layout.ghosts);
  work(part.layout.first_owned);
  work(part.tetrahedra);
  work(part.tetrahedron_number);
  work(part.counted);
  work(part.boundary);
  work(part.boundary_number);
}

}  // namespace

void send_shares(const SampleGroup& group, std::uint64_t sample, std::span<geometry::Subdomain> parts) {
  const auto& control = group.control();
  for (int rank = 1; rank < group.size(); ++rank) {
    const auto& part = parts[index(rank)];
    ShareHeader header{sample, part.layout.n_global, part.n_tetrahedra_global, part.layout.n_owned, {}};
    std::size_t i = 0;
    for_each_array(part, [&](const auto& array) { header.lengths[i++] = array.size(); });
    parallel::send_bytes(control, std::as_bytes(std::span(&header, 1)), rank, share_tag);
  }
  parallel::agree(control, [&] { group.computation().enter(sharing_stage); });
  for (int rank = 1; rank < group.size(); ++rank) {
    auto& part = parts[index(rank)];
    for_each_array(part, [&](const auto& array) { parallel::send_array(control, array, rank, share_tag); });
    part = {};
  }
}

void send_end(const SampleGroup& group) {
  for (int rank = 1; rank < group.size(); ++rank) parallel::send_bytes(group.control(), {}, rank, share_tag);
}

std::optional<ShareHeader> receive_header(const SampleGroup& group) {
  ShareHeader header;
  if (parallel::receive_length(group.control(), 0, share_tag, sizeof(header)) == 0) return std::nullopt;
  parallel::receive_pieces(group.control(), std::as_writable_bytes(std::span(&header, 1)), 0, share_tag);
  return header;
}

geometry::Subdomain receive_share(const SampleGroup& group, const ShareHeader& header) {
  const auto& control = group.control();
  geometry::Subdomain part;
  part.layout.n_global = header.n_nodes_global;
  part.n_tetrahedra_global = header.n_tetrahedra_global;
  part.layout.n_owned = static_cast<std::int32_t>(header.n_owned);
  parallel::agree(control, [&] {
    group.computation().enter(sharing_stage);
    std::size_t i = 0;
    for_each_array(part, [&](auto& array) { array.resize(header.lengths[i++]); });
  });
  for_each_array(part, [&](auto& array) {
    const auto bytes = std::as_writable_bytes(std::span(array));
    if (parallel::receive_length(control, 0, share_tag, 1) != bytes.size())
      throw std::runtime_error("a part of a sample arrived with an unexpected length");
    parallel::receive_pieces(control, bytes, 0, share_tag);
  });
  return part;
}

}  // namespace crackle::ensemble
