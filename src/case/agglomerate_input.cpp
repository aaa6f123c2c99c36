#include "src/case/agglomerate_input.hpp"
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include "src/base/error.hpp"
#include "src/case/csv.hpp"
#include "src/case/reading.hpp"

namespace quern {
namespace {

BondCase read_bond(const Values& v, const std::string& a, const std::string& b, const std::vector<std::string>& species) {
  const std::string t = a == "default" ? "bond.default" : "bond." + a + "." + b;
  for (const std::string& name : {a, b})
    if (a != "default" && std::find(species.begin(), species.end(), name) == species.end())
      v.refuse(t, fmt::format("found \"{}\", which is no species of this case; allowed is {}", name, quoted_list(species)));
  BondCase bond{a, b, {}};
  BondMaterial& m = bond.material;
  m.name = a == "default" ? "default" : a + "." + b;
  m.radius_ratio = v.number(t + ".radius_ratio");
  if (v.has(t + ".young") == v.has(t + ".normal_stiffness")) v.refuse(t, "a bond needs young or normal_stiffness, one of the two");
  const double ratio = v.number(t + ".stiffness_ratio");
  if (const auto young = v.number_if(t + ".young")) m.young = *young, m.shear_modulus = *young / ratio;
  else m.normal_stiffness = v.number(t + ".normal_stiffness"), m.shear_stiffness = m.normal_stiffness / ratio;
  const double damping = v.number(t + ".damping");
  m.damping = {damping, damping, damping, damping};
  if (const auto strength = v.number_if(t + ".tensile_strength")) m.strength.tensile = *strength;
  if (const auto strength = v.number_if(t + ".shear_strength")) m.strength.shear = *strength;
  const std::string law = v.text(t + ".strength");
  m.strength.deviation = v.number(t + ".deviation");
  m.strength.rate_exponent = v.number(t + ".rate_exponent");
  m.strength.reference_rate = v.number(t + ".reference_rate");
  m.strength.size_exponent = v.number(t + ".size_exponent");
  if (m.strength.size_exponent != 0) {
    require(v, t, "reference_size", "a strength that depends on the size of the body");
    m.strength.reference_size = v.number(t + ".reference_size");
  }
  if (law == "normal") m.strength.distribution = StrengthDistribution::normal;
  if (law == "weibull") {
    m.strength.distribution = StrengthDistribution::weibull;
    require(v, t, "modulus", "a strength by Weibull's law");
    m.strength.modulus = v.number(t + ".modulus");
  }
  return bond;
}

BodyShape read_shape(const Values& v, const std::string& t, const std::string& shape) {
  const auto need = [&](const char* leaf) { require(v, t, leaf, "a body of shape " + shape); };
  if (shape == "sphere" || shape == "cylinder") need("radius");
  if (shape == "cylinder") need("length");
  if (shape == "box" || shape == "superquadric") need("size");
  if (shape == "sphere") return SphereRegion{v.number(t + ".radius")};
  if (shape == "cylinder") {
    const double half = 0.5 * v.number(t + ".length");
    return CylinderRegion{v.number(t + ".radius"), -half, half};
  }
  if (shape == "mesh") return need("file"), Mesh{};
  const Vec3 half = 0.5 * v.vector(t + ".size");
  if (shape == "superquadric") return SuperquadricRegion{{half.x(), half.y(), half.z()}, v.number(t + ".exponent")};
  return BoxRegion{-half, half};
}

std::vector<Grain> read_assembly(const Values& v, const std::string& key, const std::vector<std::uint8_t>& kinds) {
  const std::string file = beside(v, key);
  const NumberTable table = read_numbers(file);
  for (const std::string& column : table.names)
    if (column != "x" && column != "y" && column != "z" && column != "diameter" && column != "kind")
      v.refuse(key, fmt::format("found the column \"{}\" in {}; allowed are x, y, z, diameter and kind", column, file));
  for (const char* column : {"x", "y", "z", "diameter"})
    if (!table.find(column)) v.refuse(key, fmt::format("the column {} [m] is missing in {}", column, file));
  std::vector<Grain> grains;
  for (std::size_t row = 0; row < table.columns[0].size(); ++row) {
    const auto cell = [&](const char* column) { return (*table.find(column))[row]; };
    Grain grain{{cell("x"), cell("y"), cell("z")}, cell("diameter"), kinds[0]};
    if (!(grain.diameter > 0)) v.refuse(key, fmt::format("found the diameter {} in {}; allowed is more than 0 m", grain.diameter, file));
    if (table.find("kind")) {
      const double kind = cell("kind");
      if (!(kind >= 0 && kind < static_cast<double>(kinds.size()) && kind == std::floor(kind)))
        v.refuse(key, fmt::format("found the kind {} in {}; allowed are 0 to {}, the places in grains", kind, file, kinds.size() - 1));
      grain.species = kinds[static_cast<std::size_t>(kind)];
    }
    grains.push_back(grain);
  }
  if (grains.empty()) v.refuse(key, fmt::format("found no grain in {}; allowed is at least one", file));
  return grains;
}

AgglomerateCase read_agglomerate(const Values& v, const std::string& name, const Case& c) {
  const std::string t = "agglomerate." + name;
  AgglomerateCase body;
  body.name = name;
  body.where = v.where.at(split_path(t));
  require(v, t, "grains", "an agglomerate");
  const std::vector<std::string> species = names_of(c.species), grains = v.texts(t + ".grains");
  if (grains.empty()) v.refuse(t + ".grains", "found no species; allowed is at least one");
  std::vector<std::uint8_t> kinds;
  for (const std::string& grain : grains) {
    const auto found = std::find(species.begin(), species.end(), grain);
    if (found == species.end()) v.refuse(t + ".grains", fmt::format("found \"{}\", which is no species of this case; allowed is {}", grain, quoted_list(species)));
    kinds.push_back(static_cast<std::uint8_t>(found - species.begin()));
  }
  double smallest = 1e300;
  for (const std::uint8_t kind : kinds) smallest = std::min(smallest, c.species[kind].sizes.smallest());
  if (v.has(t + ".shape") == v.has(t + ".assembly")) v.refuse(t, "an agglomerate needs a shape or an assembly, one of the two");
  if (v.has(t + ".assembly")) {
    body.grains = read_assembly(v, t + ".assembly", kinds);
    for (const Grain& grain : body.grains) smallest = std::min(smallest, grain.diameter);
  } else {
    body.request.shape = read_shape(v, t, v.text(t + ".shape"));
    if (std::holds_alternative<Mesh>(body.request.shape)) body.mesh = {beside(v, t + ".file"), v.number(t + ".scale")};
    const std::vector<double> shares = v.has(t + ".shares") ? v.numbers(t + ".shares") : std::vector<double>(kinds.size(), 1.0);
    if (shares.size() != kinds.size()) v.refuse(t + ".shares", fmt::format("found {} numbers; allowed are as many as grains, {}", shares.size(), kinds.size()));
    for (std::size_t k = 0; k < kinds.size(); ++k) body.request.portions.push_back({kinds[k], c.species[kinds[k]].sizes, shares[k]});
    body.request.solid_fraction = v.number_if(t + ".solid_fraction");
    body.request.seed = c.seed;
  }
  body.triangulated = v.text(t + ".bonding") == "triangulation";
  body.gap = v.number_if(t + ".gap").value_or(0.1 * smallest);
  return body;
}

}  // namespace

void read_agglomerates(const Values& v, Case& c) {
  const std::vector<std::string> species = names_of(c.species);
  for (const std::string& a : v.names("bond")) {
    if (a == "default") c.bonds.push_back(read_bond(v, "default", "default", species));
    else
      for (const std::string& b : v.names("bond." + a)) c.bonds.push_back(read_bond(v, a, b, species));
  }
  for (const std::string& name : v.names("agglomerate")) c.agglomerates.push_back(read_agglomerate(v, name, c));
}

}  // namespace quern
