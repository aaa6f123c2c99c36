// A case: everything that a user can ask for, checked, in SI units. Plain data; src/case/build.hpp makes a simulation of it.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>
#include "bonds/agglomerate.hpp"
#include "mills/frame.hpp"
#include "mills/planetary.hpp"
#include "mills/stirred.hpp"
#include "mills/tumbling.hpp"
#include "shapes/superquadric.hpp"
#include "src/base/domain.hpp"
#include "src/case/echo.hpp"
#include "src/contact/laws.hpp"
#include "src/field/fields.hpp"
#include "src/material/material.hpp"
#include "src/observe/instrument.hpp"
#include "src/observe/observer_settings.hpp"
#include "src/particle/size_distribution.hpp"

namespace quern {

enum class LawKind { linear, hertz_mindlin, deresiewicz, power_law, linearized };

// What a table [pair.<a>.<b>] says.
struct PairCase {
  std::string a, b;   // "default" twice for [pair.default]
  std::string where;  // in the file
  LawKind law = LawKind::hertz_mindlin;
  std::optional<double> restitution;            // [-]
  double friction = 0;                          // [-]
  std::optional<double> normal_stiffness;       // [N/m]
  std::optional<double> penetration_factor;     // [-]
  std::optional<double> max_speed;              // [m/s]
  std::optional<double> tangential_stiffness;   // [N/m]
  double tangential_ratio = 0;                  // [-]
  std::optional<double> normal_damping;         // [kg/s]
  std::optional<double> stiffness_coefficient;  // [N/m^r]
  double stiffness_exponent = 0;
  std::optional<double> damping_coefficient;    // [N s/m^(s+1)]
  double damping_exponent = 0;
  std::optional<double> impact_mass;            // [kg]
  std::optional<double> impact_speed;           // [m/s]
  double reference_speed = 0;                   // [m/s]
  std::optional<double> reference_diameter;     // [m]
  Rolling rolling;
  Extras effects;            // as read: src/case/effects_input.hpp completes them
  double unloading_ratio = 1;  // [-]
};

struct SpeciesCase {
  std::string name;
  std::uint8_t material = 0;
  double density = 0;  // [kg/m³]
  SizeDistribution sizes;                  // of a superquadric: the ball that holds it
  std::optional<Superquadric> shape = {};  // none: a sphere
};

// A part that an STL file has instead of numbers.
struct MeshFile {
  std::string name;  // absolute; "": none
  double scale = 1;  // [m per unit of the file]
};

// What a table [bond.<a>.<b>] says of two species.
struct BondCase {
  std::string a, b;  // "default" twice for [bond.default]
  BondMaterial material;
};

struct AgglomerateCase {
  std::string name, where;
  BodyRequest request;        // its seed is the case's; a mesh is read when it is built
  MeshFile mesh;
  std::vector<Grain> grains;  // read from a file, instead of a request
  bool triangulated = false;
  double gap = 0;             // [m]
};

struct FrameCase {
  std::string name, parent;  // parent "": the fixed frame
  Motion motion;
};

struct WallCase {
  enum class Type { plane, cylinder, cone, disc, mesh };
  std::string name, frame, where;
  Type type = Type::plane;
  std::uint8_t material = 0;
  Vec3 point = Vec3::Zero(), axis = Vec3::UnitZ();
  double radius = 0, end_radius = 0, inner_radius = 0, length = 0;  // [m]
  Revolved::Side side = Revolved::Side::both;
  std::string file;  // mesh, absolute
  double scale = 1;
  bool open = false;  // mesh: need not be closed
};

struct InsertCase {
  enum class Method { packing, rain, list };
  enum class Shape { mill, box, cylinder, sphere };
  struct Ball {
    Vec3 position, velocity, spin;  // [m], [m/s], [rad/s]
    double diameter = 0;            // [m]; 0: drawn from the species
  };
  std::string name, where;
  std::uint8_t species = 0;
  std::optional<std::size_t> agglomerate;  // instead of the species
  Vec3 turn = Vec3::Zero();                // of listed agglomerates [rad]
  Method method = Method::packing;
  std::int64_t count = 0;  // one of count, mass, filling
  double mass = 0;         // [kg]
  double filling = 0;
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();
  std::vector<Ball> balls;  // list
  double allowed_overlap = 0;  // list: at the start, in radii
  Shape shape = Shape::mill;
  Vec3 centre = Vec3::Zero(), axis = Vec3::UnitZ(), size = Vec3::Zero();
  double radius = 0, length = 0;  // [m]
};

struct OutputCase {
  double frames = 0, energy = 0;  // intervals [s]
  bool paraview = true, trajectory = true, pictures = true;
  std::vector<double> stages;  // [s]
};

struct Case {
  std::string file;   // as the user wrote it
  std::string name, title;
  std::string text;   // the complete case, TOML: an echo that names copies of its files
  std::vector<NamedFile> files;  // of which they are copies
  double duration = 0;  // [s]
  std::uint64_t seed = 1;
  Vec3 gravity{0, 0, -9.81};  // [m/s²]
  std::optional<double> time_step;  // [s]
  std::string time_step_where;      // in the file
  double time_step_fraction = 0.2;
  bool unsafe_time_step = false;
  bool looked_at = false;           // built before with other numbers: its time step is taken as it is, and no warnings are sought
  std::vector<Material> materials;
  std::vector<PairCase> pairs;
  std::vector<SpeciesCase> species;
  std::vector<BondCase> bonds;
  std::vector<AgglomerateCase> agglomerates;
  std::vector<FrameCase> frames;  // parents before their children
  std::vector<WallCase> walls;
  std::optional<TumblingMill> mill;
  std::optional<PlanetaryMill> planetary;
  std::optional<StirredMill> stirred;  // of the three at most one
  MeshFile vial_file, stirrer_file, vessel_file;
  double critical_speed = 0;      // of the mill with the largest ball [rad/s]; planetary: of the vials against the fixed frame; 0 without a mill
  std::vector<InsertCase> inserts;
  std::vector<Field> fields;      // forces on single bodies
  double carried_density = 0;     // added mass over volume [kg/m³]
  Domain domain;                  // the periodic directions of the case; a mill may add one
  OutputCase output;
  InstrumentSettings instrument;
  ObserverSettings observe;       // driven_walls and mill are filled when the simulation is built
  std::vector<std::string> driven_walls, loading_walls;
  std::vector<std::string> warnings;  // plain sentences
};

// Reads a case with the overrides ("key=value") laid over it. Throws InputError: one or two sentences that name file, line and
// key, what was found, what is allowed and the nearest valid word.
Case read_case(const std::string& file, const std::vector<std::string>& overrides = {});

class Values;
// The case that checked values mean. Throws InputError as read_case does.
Case named_case_of(Values values);
// The same without its text and files.
Case case_of(const Values& values);

}  // namespace quern
