// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/ghost_exchange.h"

#include "parallel/agreement.h"

namespace crackle::parallel {

namespace {

/// Upper bounds on PETSc's memory per sent or received node, and for the rest of an exchange [byte].
constexpr std::size_t bytes_per_local_node = 256;
constexpr std::size_t bytes_per_object = 1 << 18;

void set_graph(PetscSF forest, std::size_t n_roots, std::vector<PetscSFNode>& leaves) {
  check_petsc(PetscSFSetGraph(forest, static_cast<PetscInt>(n_roots), static_cast<PetscInt>(leaves.size()),
                              nullptr, PETSC_COPY_VALUES, leaves.data(), PETSC_COPY_VALUES),
              "PetscSFSetGraph");
  check_petsc(PetscSFSetUp(forest), "PetscSFSetUp");
}

}  // namespace

GhostForest::GhostForest(const Communicator& group, const NodeLayout& layout)
    : n_ghosts_(layout.ghosts.size()) {
  // First an exchange over all owned nodes, to find which are ghosts elsewhere; then over those only.
  std::vector<PetscSFNode> leaves;
  std::vector<PetscInt> place, ghost_place;
  PetscOwner<PetscSF, PetscSFDestroy> all;
  agree(group, [&] {
    for (const auto& ghost : layout.ghosts) leaves.push_back({ghost.rank, ghost.node});
    place.resize(static_cast<std::size_t>(layout.n_owned), -1);
    ghost_place.resize(n_ghosts_);
    sent_nodes_.reserve(place.size());
    check_room(3 * (bytes_per_local_node * layout.number.size() + bytes_per_object));
  });
  if (group.size() == 1) return;
  check_petsc(PetscSFCreate(group.get(), all.put()), "PetscSFCreate");
  set_graph(all.get(), place.size(), leaves);
  const PetscInt* degree = nullptr;
  check_petsc(PetscSFComputeDegreeBegin(all.get(), &degree), "PetscSFComputeDegreeBegin");
  check_petsc(PetscSFComputeDegreeEnd(all.get(), &degree), "PetscSFComputeDegreeEnd");
  for (std::int32_t node = 0; node < layout.n_owned; ++node) {
    if (degree[node] == 0) continue;
    place[index(node)] = static_cast<PetscInt>(sent_nodes_.size());
    sent_nodes_.push_back(node);
  }
  check_petsc(PetscSFBcastBegin(all.get(), MPIU_INT, place.data(), ghost_place.data(), MPI_REPLACE),
              "PetscSFBcastBegin");
  check_petsc(PetscSFBcastEnd(all.get(), MPIU_INT, place.data(), ghost_place.data(), MPI_REPLACE),
              "PetscSFBcastEnd");
  for (std::size_t i = 0; i < leaves.size(); ++i) leaves[i].index = ghost_place[i];
  check_petsc(PetscSFCreate(group.get(), forest_.put()), "PetscSFCreate");
  set_graph(forest_.get(), sent_nodes_.size(), leaves);
}

void GhostForest::begin(MPI_Datatype type, const void* sent, void* received) const {
  if (forest_.get() == nullptr) return;
  check_petsc(PetscSFBcastBegin(forest_.get(), type, sent, received, MPI_REPLACE), "PetscSFBcastBegin");
}

void GhostForest::end(MPI_Datatype type, const void* sent, void* received) const {
  if (forest_.get() == nullptr) return;
  check_petsc(PetscSFBcastEnd(forest_.get(), type, sent, received, MPI_REPLACE), "PetscSFBcastEnd");
}

}  // namespace crackle::parallel
