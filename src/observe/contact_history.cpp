#include "src/observe/contact_history.hpp"

#include <algorithm>

namespace quern {

namespace {

struct Instant {
  double overlap, closing, force;
};

std::size_t row_of(const Particles& particles, Index id) {
  return static_cast<std::size_t>(std::find(particles.id.begin(), particles.id.end(), id) - particles.id.begin());
}

double force_of(const Simulation& s, const Collision& c, std::uint8_t a, std::uint8_t b, const Approach<double>& approach) {
  const PairLaw& pair = s.pair_laws[s.pair_kind[a * s.materials.size() + b]];
  if (pair.extras.any()) return c.force;
  return std::visit(
      [&](const auto& law) {
        TangentialSpring<double> spring{};
        return act(law, approach, spring).normal;
      },
      pair.law);
}

Instant instant_of(const Simulation& s, const Collision& c) {
  const Particles& p = s.particles;
  const std::size_t i = row_of(p, c.first_id);
  const double mass = p.velocity[i].w, radius = p.position[i].w;
  if (c.second_id >= 0) {
    const std::size_t j = row_of(p, c.second_id);
    const Triple<double> apart = s.domain.nearest(xyz(p.position[i]) - xyz(p.position[j]));
    const double distance = length(apart), radius_j = p.position[j].w, mass_j = p.velocity[j].w;
    const double overlap = std::max(0.0, radius + radius_j - distance);
    const double rate = dot(xyz(p.velocity[i]) - xyz(p.velocity[j]), apart) / distance;
    const double effective_radius = radius * radius_j / (radius + radius_j), effective_mass = mass * mass_j / (mass + mass_j);
    return {overlap, -rate, force_of(s, c, p.material[i], p.material[j], head_on(overlap, rate, effective_radius, effective_mass))};
  }
  const Wall& wall = s.walls[static_cast<std::size_t>(-1 - c.second_id)];
  Touch touches[most_touches];
  const Vec3 centre = vec(p.position[i]);
  const int count = touch_wall(wall, centre, radius, touches);
  if (count == 0) return {0, 0, 0};
  // A mesh may be touched at several points: the deepest is shown.
  const Touch& touch = *std::min_element(touches, touches + count, [](const Touch& a, const Touch& b) { return a.distance < b.distance; });
  const double overlap = std::max(0.0, radius - touch.distance);
  const double rate = (vec(p.velocity[i]) - wall.pose.velocity_at(touch.point)).dot(touch.normal);
  return {overlap, -rate, force_of(s, c, p.material[i], wall.material, head_on(overlap, rate, radius, mass))};
}

ContactCourse& course_of(std::vector<ContactCourse>& contacts, const Collision& c) {
  // Which of two particles comes first changes when they are sorted in space.
  const bool swap = c.second_id >= 0 && c.second_id < c.first_id;
  const Index first = swap ? c.second_id : c.first_id, second = swap ? c.first_id : c.second_id;
  for (auto course = contacts.rbegin(); course != contacts.rend(); ++course)
    if (course->lasting && course->first == first && course->second == second && course->start == c.record.start_time) return *course;
  ContactCourse fresh;
  fresh.first = first, fresh.second = second, fresh.start = c.record.start_time;
  contacts.push_back(fresh);
  return contacts.back();
}

void take(ContactCourse& course, const Collision& c, double now) {
  course.end = c.lasting ? now : c.end_time;
  course.lasting = c.lasting;
  course.normal_speed = c.record.normal_speed, course.tangential_speed = c.record.tangential_speed;
  course.peak_force = c.record.peak_force, course.peak_overlap = c.record.peak_overlap;
  course.normal_loss = c.record.normal_loss, course.tangential_loss = c.record.tangential_loss;
}

}  // namespace

void ContactHistory::see(const Simulation& s) {
  if (wall_names.empty())
    for (const Wall& wall : s.walls) wall_names.push_back(wall.name);
  const double now = s.clock.time();
  for (const Collision& c : s.ended_collisions()) take(course_of(contacts, c), c, now);
  for (const Collision& c : s.lasting_collisions()) {
    if (c.record.start_time < 0) continue;  // near, but without a force yet
    ContactCourse& course = course_of(contacts, c);
    take(course, c, now);
    const Instant instant = instant_of(s, c);
    course.time.push_back(now);
    course.force.push_back(instant.force);
    course.overlap.push_back(instant.overlap);
    course.closing.push_back(instant.closing);
  }
}

std::vector<Table> ContactHistory::tables() const {
  Column number{"contact", "1", "number of the contact", {}, {}}, first{"particle", "1", "id of the particle", {}, {}},
      second{"against", "1", "id of the other particle, or name of the wall", {}, {}}, start{"start", "s", "first touch", {}, {}},
      end{"end", "s", "parting, or the end of the run", {}, {}}, duration{"duration", "s", "of the overlap; the force may end before it", {}, {}}, lasting{"lasting", "1", "1: still touching at the end", {}, {}},
      normal_speed{"normal_speed", "m/s", "speed of approach at first touch", {}, {}}, tangential_speed{"tangential_speed", "m/s", "at first touch", {}, {}},
      peak_force{"peak_force", "N", "greatest normal force", {}, {}}, peak_overlap{"peak_overlap", "m", "greatest overlap", {}, {}},
      normal_loss{"normal_loss", "J", "dissipated along the normal", {}, {}}, tangential_loss{"tangential_loss", "J", "dissipated by sliding and rolling", {}, {}};
  Column of{"contact", "1", "number of the contact", {}, {}}, time{"t", "s", "", {}, {}}, since{"since_touch", "s", "time since first touch", {}, {}},
      force{"force", "N", "normal force", {}, {}}, overlap{"overlap", "m", "", {}, {}}, closing{"closing_speed", "m/s", "speed of approach; negative while parting", {}, {}};
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ContactCourse& c = contacts[k];
    const auto count = static_cast<double>(k + 1);
    number.values.push_back(count);
    first.values.push_back(c.first);
    second.labels.push_back(c.second >= 0 ? std::to_string(c.second) : wall_names[static_cast<std::size_t>(-1 - c.second)]);
    start.values.push_back(c.start), end.values.push_back(c.end), duration.values.push_back(c.end - c.start);
    lasting.values.push_back(c.lasting ? 1 : 0);
    normal_speed.values.push_back(c.normal_speed), tangential_speed.values.push_back(c.tangential_speed);
    peak_force.values.push_back(c.peak_force), peak_overlap.values.push_back(c.peak_overlap);
    normal_loss.values.push_back(c.normal_loss), tangential_loss.values.push_back(c.tangential_loss);
    for (std::size_t n = 0; n < c.time.size(); ++n) {
      of.values.push_back(count);
      time.values.push_back(c.time[n]), since.values.push_back(c.time[n] - c.start);
      force.values.push_back(c.force[n]), overlap.values.push_back(c.overlap[n]), closing.values.push_back(c.closing[n]);
    }
  }
  return {{"contacts", "every contact", {number, first, second, start, end, duration, lasting, normal_speed, tangential_speed, peak_force, peak_overlap, normal_loss, tangential_loss}},
          {"contact_history", "force and overlap of every contact against time", {of, time, since, force, overlap, closing}}};
}

}  // namespace quern
