// The agglomerates of a case: each is packed once, and its copies are put where they are wanted.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>
#include "src/case/case.hpp"
#include "src/engine/simulation.hpp"

namespace quern {

class Bodies {
 public:
  Bodies(const Case& c, Simulation& s) : case_(c), simulation_(s), made_(c.agglomerates.size()) {}

  // Adds a copy: its grains about `centre` [m], turned, with velocity [m/s] and spin [rad/s] as a rigid body, and its bonds.
  void add(std::size_t agglomerate, const Vec3& centre, const Mat3& turn, const Vec3& velocity, const Vec3& spin);
  // An insertion's amount as a number of balls that each hold a body, whichever way it is turned. `reference_volume`: of its filling [m³].
  Portion portion(const InsertCase& insert, double reference_volume);
  std::vector<std::pair<std::string, BodyReport>> reports() const;

 private:
  struct Body {
    std::vector<Grain> grains;
    GrainPairs pairs;
    double reach = 0, mass = 0, solid = 0;  // [m], [kg], [m³]
    BodyReport report;
  };
  const Body& body(std::size_t agglomerate);
  Index material_of(const AgglomerateCase& agglomerate, std::uint8_t a, std::uint8_t b);

  const Case& case_;
  Simulation& simulation_;
  std::vector<std::optional<Body>> made_;
};

}  // namespace quern
