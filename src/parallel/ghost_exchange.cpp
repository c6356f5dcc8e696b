// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/parallel/ghost_exchange.h"

#include "crackle/parallel/agreement.h"

#include <algorithm>
#include <type_traits>

namespace crackle::parallel {

namespace {

/// What PETSc needs for a node that is sent or received at most, and for the rest of an exchange [byte].
constexpr std::size_t bytes_per_node = 256;
constexpr std::size_t bytes_per_object = 1 << 18;

/// The rank and the owned number there of each ghost.
std::vector<PetscSFNode> ghost_owners(const Communicator& group, const geometry::Subdomain& subdomain) {
  std::int64_t end = subdomain.n_owned;
  std::vector<std::int64_t> ends(static_cast<std::size_t>(group.size()));
  agree(group);
  check_mpi(MPI_Scan(MPI_IN_PLACE, &end, 1, MPI_INT64_T, MPI_SUM, group.get()), "MPI_Scan");
  check_mpi(MPI_Allgather(&end, 1, MPI_INT64_T, ends.data(), 1, MPI_INT64_T, group.get()), "MPI_Allgather");
  std::vector<PetscSFNode> owners;
  for (auto i = static_cast<std::size_t>(subdomain.n_owned); i < subdomain.nodes.size(); ++i) {
    const std::int64_t number = subdomain.distributed_number[i];
    const auto rank = std::ranges::upper_bound(ends, number) - ends.begin();
    const std::int64_t first = rank == 0 ? 0 : ends[static_cast<std::size_t>(rank) - 1];
    owners.push_back({static_cast<PetscInt>(rank), static_cast<PetscInt>(number - first)});
  }
  return owners;
}

void set_graph(PetscSF forest, std::int32_t n_roots, std::vector<PetscSFNode>& owners) {
  check_petsc(PetscSFSetGraph(forest, n_roots, static_cast<PetscInt>(owners.size()), nullptr,
                              PETSC_COPY_VALUES, owners.data(), PETSC_COPY_VALUES),
              "PetscSFSetGraph");
  check_petsc(PetscSFSetUp(forest), "PetscSFSetUp");
}

}  // namespace

template <class Integer>
GhostExchange<Integer>::GhostExchange(const Communicator& group, const geometry::Subdomain& subdomain) {
  const MPI_Datatype number = std::is_same_v<Integer, std::int32_t> ? MPI_INT32_T : MPI_INT64_T;
  check_mpi(MPI_Type_contiguous(3, number, &type_), "MPI_Type_contiguous");
  check_mpi(MPI_Type_commit(&type_), "MPI_Type_commit");
  const auto agree_on_room = [&](std::size_t n_nodes) {
    agree(group, [&] { check_room(bytes_per_node * n_nodes + bytes_per_object); });
  };

  // First among all owned nodes, to learn which of them are ghosts elsewhere; then among those only.
  auto owners = ghost_owners(group, subdomain);
  PetscOwner<PetscSF, PetscSFDestroy> all;
  agree_on_room(subdomain.nodes.size());
  check_petsc(PetscSFCreate(group.get(), all.put()), "PetscSFCreate");
  set_graph(all.get(), subdomain.n_owned, owners);
  const PetscInt* degree = nullptr;
  check_petsc(PetscSFComputeDegreeBegin(all.get(), &degree), "PetscSFComputeDegreeBegin");
  check_petsc(PetscSFComputeDegreeEnd(all.get(), &degree), "PetscSFComputeDegreeEnd");
  std::vector<PetscInt> place(static_cast<std::size_t>(subdomain.n_owned), -1);
  for (std::int32_t node = 0; node < subdomain.n_owned; ++node) {
    if (degree[node] == 0) continue;
    place[static_cast<std::size_t>(node)] = static_cast<PetscInt>(sent_nodes_.size());
    sent_nodes_.push_back(node);
  }
  std::vector<PetscInt> ghost_place(owners.size());
  agree_on_room(subdomain.nodes.size());
  check_petsc(PetscSFBcastBegin(all.get(), MPIU_INT, place.data(), ghost_place.data(), MPI_REPLACE),
              "PetscSFBcastBegin");
  check_petsc(PetscSFBcastEnd(all.get(), MPIU_INT, place.data(), ghost_place.data(), MPI_REPLACE),
              "PetscSFBcastEnd");
  for (std::size_t i = 0; i < owners.size(); ++i) owners[i].index = ghost_place[i];
  sent_.resize(sent_nodes_.size());
  received_.resize(owners.size());
  agree_on_room(sent_.size() + received_.size());
  check_petsc(PetscSFCreate(group.get(), forest_.put()), "PetscSFCreate");
  set_graph(forest_.get(), static_cast<std::int32_t>(sent_nodes_.size()), owners);
  // The first exchange allocates, the later ones do not.
  begin();
  end();
  n_exchanges_ = 0;
}

template <class Integer>
GhostExchange<Integer>::~GhostExchange() {
  MPI_Type_free(&type_);
}

template <class Integer>
void GhostExchange<Integer>::begin() {
  check_petsc(PetscSFBcastBegin(forest_.get(), type_, sent_.data(), received_.data(), MPI_REPLACE),
              "PetscSFBcastBegin");
}

template <class Integer>
void GhostExchange<Integer>::end() {
  check_petsc(PetscSFBcastEnd(forest_.get(), type_, sent_.data(), received_.data(), MPI_REPLACE),
              "PetscSFBcastEnd");
  ++n_exchanges_;
}

template class GhostExchange<std::int32_t>;
template class GhostExchange<std::int64_t>;

}  // namespace crackle::parallel
