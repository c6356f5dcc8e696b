// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact_at_rest.h"

#include "common/index.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace crackle::dynamics {

namespace {

/// A cut closes in the end if it does so at more than this share of the largest rate of strain.
constexpr double least_closing_share = 1e-6;

double along(const mechanics::CutContact& cut, const mechanics::Symmetric& strain) {
  return dot(cut.normal, mechanics::apply(strain, cut.normal));
}

}  // namespace

mechanics::Symmetric ContactAtRest::strain(std::size_t contact, std::span<const double> displacement) const {
  return body_->strain(std::as_const(*body_).residual_stiffness().contacts()[contact], displacement);
}

bool ContactAtRest::closes(const Strain& strain) const {
  const auto& stiffness = std::as_const(*body_).residual_stiffness();
  bool closes = false;
  for (std::size_t i = 0; i < stiffness.contacts().size() && !closes; ++i)
    closes = !stiffness.cut_contact(i).is_apart &&
             along(stiffness.cut_contact(i), strain(stiffness.contacts()[i])) < -mechanics::surely_open;
  parallel::check_peers(*group_);
  return parallel::any_of_all(*group_, closes);
}

bool ContactAtRest::closes(std::span<const double> displacement) const {
  return closes([&](std::int32_t t) { return body_->strain(t, displacement); });
}

bool ContactAtRest::closes_in_the_end(const Strain& rate) const {
  const auto& stiffness = std::as_const(*body_).residual_stiffness();
  double fastest = 0, largest = 0;
  for (std::size_t i = 0; i < stiffness.contacts().size(); ++i) {
    if (stiffness.cut_contact(i).is_apart) continue;
    const mechanics::Symmetric strain = rate(stiffness.contacts()[i]);
    fastest = std::max(fastest, -along(stiffness.cut_contact(i), strain));
    for (const double component : strain) largest = std::max(largest, std::abs(component));
  }
  parallel::check_peers(*group_);
  fastest = parallel::largest_of_all(*group_, fastest);
  return fastest > least_closing_share * parallel::largest_of_all(*group_, largest);
}

void ContactAtRest::start(std::span<const double> displacement) {
  auto& stiffness = body_->residual_stiffness();
  for (std::size_t i = 0; i < stiffness.contacts().size(); ++i) {
    mechanics::CutContact& cut = stiffness.cut_contact(i);
    const bool is_apart = cut.is_apart;
    const mechanics::Symmetric strain = this->strain(i, displacement);
    stiffness.start_contact(i, strain);
    cut.closed_at = 0;
    cut.is_open = along(cut, strain) > mechanics::surely_open;
    cut.is_apart = is_apart;
  }
  start();
}

void ContactAtRest::start() {
  auto& stiffness = body_->residual_stiffness();
  for (std::size_t i = 0; i < stiffness.contacts().size(); ++i) {
    stiffness.cut_contact(i).dissipated = 0;
    stiffness.cut_contact(i).rests = false;
  }
  stiffness.find_acting();
  stiffness.let_contacts_act(true);
}

void ContactAtRest::take_over(std::span<const std::int32_t> changes) {
  const auto& stiffness = std::as_const(*body_).residual_stiffness();
  tangents_.resize(stiffness.contacts().size());
  for (const auto t : changes) {
    const std::int32_t contact = stiffness.contact_number(t);
    tangent_.linearize(t, stiffness, contact < 0 ? mechanics::CutTangent{} : tangents_[index(contact)]);
  }
}

std::vector<std::int32_t> ContactAtRest::linearize(std::span<const double> displacement) {
  const auto& stiffness = std::as_const(*body_).residual_stiffness();
  std::vector<std::int32_t> changed;
  for (std::size_t i = 0; i < tangents_.size(); ++i) {
    const std::int32_t t = stiffness.contacts()[i];
    const mechanics::CutTangent now = stiffness.cut_tangent(i, strain(i, displacement));
    if (now == tangents_[i]) continue;
    tangents_[i] = now;
    tangent_.linearize(t, stiffness, now);
    changed.push_back(t);
  }
  return changed;
}

void ContactAtRest::settle(std::span<const double> displacement) {
  auto& stiffness = body_->residual_stiffness();
  dissipated_.resize(stiffness.contacts().size());
  for (std::size_t i = 0; i < dissipated_.size(); ++i) {
    stiffness.settle_contact(i, strain(i, displacement));
    dissipated_[i] += std::exchange(stiffness.cut_contact(i).dissipated, 0);
  }
}

double ContactAtRest::dissipated() const {
  std::vector<double> sum;
  const auto contacts = std::as_const(*body_).residual_stiffness().contacts();
  for (std::size_t i = 0; i < dissipated_.size(); ++i)
    if (body_->subdomain().owned[index(contacts[i])] != 0) sum.push_back(dissipated_[i]);
  return parallel::exact_sum(*group_, sum);
}

parallel::NumberedRows save_cuts(const parallel::Communicator& group, const fracture::BreakableBody& body) {
  const geometry::Subdomain& part = body.subdomain();
  const auto& stiffness = body.residual_stiffness();
  const auto word = [](double value) { return std::bit_cast<std::int64_t>(value); };
  parallel::NumberedRows cuts;
  cuts.width = 8;
  for (std::size_t i = 0; i < stiffness.contacts().size(); ++i) {
    const auto t = index(stiffness.contacts()[i]);
    if (part.owned[t] == 0) continue;
    const mechanics::CutContact& cut = stiffness.cut_contact(i);
    cuts.numbers.push_back(part.tetrahedron_number[t]);
    cuts.values.insert(cuts.values.end(),
                       {word(cut.closed_at), word(cut.slip[0]), word(cut.slip[1]), word(cut.slip[2]),
                        word(cut.friction), word(cut.dissipated), word(cut.opening_before),
                        (cut.rests ? 4 : 0) + (cut.is_apart ? 2 : 0) + (cut.is_open ? 1 : 0)});
  }
  return parallel::gather_rows(group, cuts);
}

void restore_cuts(const parallel::NumberedRows& rows, fracture::BreakableBody& body) {
  mechanics::ResidualStiffness& stiffness = body.residual_stiffness();
  for (std::size_t i = 0; i < stiffness.contacts().size(); ++i) {
    const auto v = rows.find(body.subdomain().tetrahedron_number[index(stiffness.contacts()[i])]);
    if (v.empty()) throw std::runtime_error("the checkpoint lacks a broken tetrahedron");
    const auto number = [&](std::size_t k) { return std::bit_cast<double>(v[k]); };
    mechanics::CutContact& cut = stiffness.cut_contact(i);
    cut.closed_at = number(0);
    cut.slip = {number(1), number(2), number(3)};
    cut.friction = number(4);
    cut.dissipated = number(5);
    cut.opening_before = number(6);
    cut.is_open = (v[7] & 1) != 0;
    cut.is_apart = (v[7] & 2) != 0;
    cut.rests = (v[7] & 4) != 0;
  }
  stiffness.find_acting();
}

}  // namespace crackle::dynamics
