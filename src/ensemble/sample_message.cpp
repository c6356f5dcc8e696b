// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample_message.h"

#include "crackle/common/packing.h"
#include "crackle/parallel/message.h"
#include "crackle/parallel/sleeping_wait.h"

#include <vector>

namespace crackle::ensemble {

namespace {

constexpr int master = 0;
constexpr int request_tag = 1;
constexpr int work_tag = 2;
constexpr int stop_tag = 3;
constexpr int progress_tag = 4;

}  // namespace

void send_request(const parallel::Communicator& world, const std::optional<SampleReport>& report) {
  parallel::send_array(world, report ? to_bytes(*report) : std::vector<std::byte>{}, master, request_tag);
}

std::optional<Request> poll_request(const parallel::Communicator& world) {
  const auto status = parallel::poll_message(world, MPI_ANY_SOURCE, request_tag);
  if (!status) return std::nullopt;
  Request request;
  request.rank = status->MPI_SOURCE;
  const auto bytes = parallel::receive_array<std::byte>(world, request.rank, request_tag);
  if (!bytes.empty()) request.report = report_from_bytes(bytes);
  return request;
}

void send_work(const parallel::Communicator& world, int rank, const PreparedSample& prepared) {
  Packer header;
  header.put(prepared.sample);
  header.put(prepared.seconds);
  header.put(prepared.realization.report);
  parallel::send_array(world, header.bytes(), rank, work_tag);
  parallel::send_array(world, prepared.realization.nodes, rank, work_tag);
  parallel::send_array(world, prepared.realization.tetrahedra, rank, work_tag);
  parallel::send_array(world, prepared.realization.boundary, rank, work_tag);
}

void send_no_work(const parallel::Communicator& world, int rank) {
  parallel::send_array(world, std::vector<std::byte>{}, rank, work_tag);
}

void send_stop(const parallel::Communicator& world, int rank) {
  parallel::check_mpi(MPI_Send(nullptr, 0, MPI_BYTE, rank, stop_tag, world.get()), "MPI_Send");
}

bool is_asked_to_stop(const parallel::Communicator& world) {
  return parallel::poll_message(world, master, stop_tag).has_value();
}

void discard_stop(const parallel::Communicator& world) {
  if (!is_asked_to_stop(world)) return;
  parallel::check_mpi(MPI_Recv(nullptr, 0, MPI_BYTE, master, stop_tag, world.get(), MPI_STATUS_IGNORE),
                      "MPI_Recv");
}

void send_progress(const parallel::Communicator& world, const std::string& line) {
  parallel::send_array(world, std::vector<char>(line.begin(), line.end()), master, progress_tag);
}

std::optional<std::string> poll_progress(const parallel::Communicator& world) {
  const auto status = parallel::poll_message(world, MPI_ANY_SOURCE, progress_tag);
  if (!status) return std::nullopt;
  const auto line = parallel::receive_array<char>(world, status->MPI_SOURCE, progress_tag);
  return std::string(line.begin(), line.end());
}

std::optional<PreparedSample> receive_work(const parallel::Communicator& world) {
  const auto bytes = parallel::receive_array<std::byte>(world, master, work_tag);
  if (bytes.empty()) return std::nullopt;
  Unpacker header(bytes);
  PreparedSample prepared;
  prepared.sample = header.get<std::uint64_t>();
  prepared.seconds = header.get<double>();
  prepared.realization.report = header.get<geometry::RealizationReport>();
  prepared.realization.nodes = parallel::receive_array<geometry::Point>(world, master, work_tag);
  prepared.realization.tetrahedra = parallel::receive_array<geometry::Tetrahedron>(world, master, work_tag);
  prepared.realization.boundary =
      parallel::receive_array<geometry::BoundaryTriangle>(world, master, work_tag);
  return prepared;
}

}  // namespace crackle::ensemble
