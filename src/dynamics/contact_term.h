// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/moving_body.h"
#include "dynamics/term.h"
#include "parallel/ghost_exchange.h"

#include "contact_paces.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace crackle::dynamics {

/// Contact in a dynamic phase, with Coulomb's friction: of cracks that close, and of surfaces that meet.
///
/// While the corners of a broken tetrahedron stay within its longest edge of each other, it is the body
/// between the sides of the crack, and resists closing as mechanics::ResidualStiffness has it. Its gap, one
/// tetrahedron wide, is thus as good as closed. One that
/// is wide open rests from look to look; if it closes meanwhile, it is apart. Where sides have moved apart,
/// and where other surfaces meet, nodes resist getting below faces: by a penalty force along the face's
/// normal, which the face's nodes balance by their barycentric weights, and by a tangential spring from the
/// point of the face where the node sticks, up to the friction's limit.
///
/// Within a step, nodes keep their faces and stick to their points, so that all forces but those of a
/// limited friction have a potential. Whatever changes is decided at the end of a step, and what that changes
/// of the potential is dissipated. A node's contact starts where it is first found, below the face by its
/// movement since the last look at most, without force: contact never adds energy. A node has at most one
/// face. Springs are as stiff as the lightest of their nodes allows, see ContactScale.
class ContactTerm final : public Term {
public:
  /// The context's members must outlive the object. Local.
  explicit ContactTerm(const MotionContext& context);
  ~ContactTerm() override;
  ContactTerm(const ContactTerm&) = delete;
  ContactTerm& operator=(const ContactTerm&) = delete;

  void start(double time, const MotionState& state) override;
  bool couples_nodes() const override { return touches_; }
  void add_forces(MovingNodes& nodes) override;
  void end_step(const mechanics::StepSpan& step, MovingNodes& nodes, const Drives& drives) override;

  void add_dissipated(std::vector<double>& sum) const override;
  void add_stored(const parallel::NodeField& displacement, std::vector<double>& sum) const override;
  void add_lost_at_rest(const parallel::NodeField& displacement, std::vector<double>& sum) const override;
  bool dissipates() const override { return true; }
  bool stores() const override { return true; }

  std::vector<parallel::NumberedRows> save() const override;
  void restore(const std::vector<parallel::NumberedRows>& rows) override;

private:
  /// The contact of a node with a face.
  struct Contact {
    std::int64_t face = -1;         // as in ContactPair; -1: none
    double stiffness = 0;           // [N/m]
    double offset = 0;              // depth from which on it resists [m]
    std::array<double, 3> stick{};  // barycentric coordinates of the point of the face where it sticks
    double friction = 0;            // magnitude of the tangential force when it was settled last [N]
    double energy = 0;              // [J]
  };
  /// A node of the pairs as ranks tell each other of it.
  struct Node {
    std::int64_t number;
    parallel::GhostSource source;
    Vector at_start;
    double mass;
    Contact contact;
  };
  /// A face that a node may meet: the corners' places in corners_.
  struct Candidate {
    std::int64_t face;
    std::array<std::size_t, 4> corners;
    std::int64_t open;
    double depth;
    double stiffness;
  };
  /// A node that may meet faces, on every rank that owns it or a corner of one of these.
  struct Meeting {
    std::size_t node;           // place in corners_
    std::size_t first, last;    // of its candidates
    double gap = 0;             // by which all must move between the search and a contact, at least [m]
    bool is_fast = false;       // the node
    bool meets_fast = false;    // any face
    std::size_t candidate = 0;  // of its contact
    Contact contact;
  };
  /// A node that this rank owns, has as a ghost, or receives.
  struct Corner {
    std::int64_t number;
    std::int32_t local;    // -1: received
    std::size_t received;  // place, if so
    Vector at_start;
    Vector now{};
  };
  /// A node relative to a face.
  struct Position {
    Vector normal;
    double twice;  // twice the face's area [m^2]
    double depth;
    std::array<double, 3> weight;  // barycentric coordinates of its foot
  };
  /// The forces of a contact at the current positions.
  struct Force {
    Position position;
    double normal = 0;    // [N]
    Vector tangential{};  // on the node [N]
    Vector slide{};       // from the point where it sticks [m]
    bool slips = false;
    double energy = 0;
  };

  std::vector<Node> own_nodes() const;  // of the pairs
  void add_meeting(std::span<const ContactPair> pairs, const auto& node_of, const auto& place_of);
  void connect();
  void receive(const MovingNodes& nodes);
  void place(std::size_t corner, const MovingNodes& nodes);
  bool is_awake(const Meeting& meeting) const;
  void find_awake();
  double gap(const Meeting& meeting) const;
  void find_gaps(const MovingNodes& nodes);
  void search(MovingNodes& nodes);
  Position position(const Meeting& meeting, const Candidate& candidate) const;
  /// The barycentric coordinates of a point in the plane of a face. @param on_face any position relative to
  /// it
  std::array<double, 3> weights(const Candidate& candidate, const Position& on_face,
                                const Vector& point) const;
  Force force(const Meeting& meeting) const;
  bool is_in_front(const Meeting& meeting, const Candidate& candidate) const;
  bool is_below(const Meeting& meeting, const Candidate& candidate, const Position& position) const;
  void settle(Meeting& meeting);
  void settle_cuts(const MovingNodes& nodes);
  bool is_mine(const Meeting& meeting) const;
  mechanics::Symmetric cut_strain(std::size_t contact, const std::array<Vector, 4>& displacement) const;
  bool is_apart(std::int32_t tetrahedron, const std::array<Vector, 4>& displacement) const;

  MotionContext context_;
  ContactScale scale_;
  bool cuts_acted_before_ = true;
  std::vector<double> dissipated_;  // at owned nodes [J]
  std::vector<Vector> work_;        // of local nodes
  ContactPaces paces_;
  std::vector<ContactPair> pairs_;                       // of all ranks
  std::unordered_map<std::int64_t, Contact> known_;      // of owned nodes, until they are connected
  std::unordered_map<std::int64_t, double> known_gaps_;  // of nodes of the pairs, likewise
  bool is_connected_ = false;
  bool touches_ = false;  // a node of any rank has contact
  std::vector<Corner> corners_;
  std::vector<Candidate> candidates_;
  std::vector<Meeting> meetings_;
  std::optional<parallel::GhostExchange<std::array<double, 3>>> exchange_;
  std::int64_t n_steps_ = 0;
  std::vector<std::size_t> awake_;  // places in meetings_ of those that may have contact before the next look
  std::vector<std::size_t> awake_corners_;  // the places of their nodes in corners_
  std::vector<std::uint8_t> is_awake_;      // of each corner
};

}  // namespace crackle::dynamics
