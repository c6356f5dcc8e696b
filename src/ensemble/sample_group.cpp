// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/sample_group.h"

#include "crackle/parallel/message.h"
#include "crackle/parallel/packing.h"

namespace crackle::ensemble {

namespace {

constexpr int share_tag = 1;

}  // namespace

SampleGroup::SampleGroup(const parallel::Communicator& ranks)
    : control_(ranks.get()), computation_(ranks.get()) {}

void SampleGroup::renew() {
  computation_ = parallel::Communicator(control_.get());
}

void send_share(const SampleGroup& group, int rank, std::uint64_t sample,
                const geometry::Subdomain& subdomain) {
  parallel::Packer header;
  header.put(sample);
  header.put(subdomain.n_nodes_global);
  header.put(subdomain.n_tetrahedra_global);
  header.put(subdomain.n_owned);
  const auto& control = group.control();
  parallel::send_array(control, header.bytes(), rank, share_tag);
  parallel::send_array(control, subdomain.nodes, rank, share_tag);
  parallel::send_array(control, subdomain.node_number, rank, share_tag);
  parallel::send_array(control, subdomain.distributed_number, rank, share_tag);
  parallel::send_array(control, subdomain.tetrahedra, rank, share_tag);
  parallel::send_array(control, subdomain.tetrahedron_number, rank, share_tag);
  parallel::send_array(control, subdomain.counted, rank, share_tag);
  parallel::send_array(control, subdomain.boundary, rank, share_tag);
  parallel::send_array(control, subdomain.boundary_number, rank, share_tag);
}

void send_end(const SampleGroup& group) {
  for (int rank = 1; rank < group.size(); ++rank) {
    parallel::send_array(group.control(), std::vector<std::byte>{}, rank, share_tag);
  }
}

std::optional<SampleShare> receive_share(const SampleGroup& group) {
  const auto& control = group.control();
  const auto bytes = parallel::receive_array<std::byte>(control, 0, share_tag);
  if (bytes.empty()) return std::nullopt;
  parallel::Unpacker header(bytes);
  SampleShare share;
  auto& subdomain = share.subdomain;
  share.sample = header.get<std::uint64_t>();
  subdomain.n_nodes_global = header.get<std::int64_t>();
  subdomain.n_tetrahedra_global = header.get<std::int64_t>();
  subdomain.n_owned = header.get<std::int32_t>();
  subdomain.nodes = parallel::receive_array<geometry::Point>(control, 0, share_tag);
  subdomain.node_number = parallel::receive_array<std::int64_t>(control, 0, share_tag);
  subdomain.distributed_number = parallel::receive_array<std::int64_t>(control, 0, share_tag);
  subdomain.tetrahedra = parallel::receive_array<geometry::Tetrahedron>(control, 0, share_tag);
  subdomain.tetrahedron_number = parallel::receive_array<std::int64_t>(control, 0, share_tag);
  subdomain.counted = parallel::receive_array<std::uint8_t>(control, 0, share_tag);
  subdomain.boundary = parallel::receive_array<geometry::BoundaryTriangle>(control, 0, share_tag);
  subdomain.boundary_number = parallel::receive_array<std::int64_t>(control, 0, share_tag);
  return share;
}

}  // namespace crackle::ensemble
