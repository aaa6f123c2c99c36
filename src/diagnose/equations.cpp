#include "src/diagnose/equations.hpp"

namespace quern {
namespace {

struct Line {
  const char *effect, *key, *equation, *where;  // key: how the case's key ends; "": any
};

constexpr Line lines[] = {
    {"air_drag", "", "F = −½ C ρ A |v| v", "C drag coefficient, ρ density of the fluid, A cross-section, v velocity"},
    {"viscous_drag", "", "F = −3π η d v", "η viscosity, d diameter, v velocity"},
    {"buoyancy", "", "F = −ρ V g", "ρ density of the displaced fluid, V volume of the body, g gravity"},
    {"added_mass", "", "(m + C ρ V) dv/dt = Σ F", "C added-mass coefficient (½: a sphere), ρ density of the fluid, V volume of the body"},
    {"magnus", "", "F = C ρ π R³ ω×v", "C Magnus coefficient, ρ density of the fluid, ω spin, v velocity"},
    {"rolling_resistance", "", "M ≤ μ_r R* F_n", "μ_r rolling friction, R* effective radius, F_n normal force; against the rolling"},
    {"torsional_friction", "", "M ≤ μ_t R* F_n", "μ_t torsional friction, R* effective radius, F_n normal force; against the spin about the normal"},
    {"sliding_friction", "", "|F_t| ≤ μ F_n", "μ friction, F_n normal force; against the sliding"},
    {"tangential_compliance", "", "ξ = κ F_t/k_t", "ξ give of the tangential spring, κ its factor on the compliance of the law (0: rigid), k_t the law's stiffness"},
    {"velocity_dependent_restitution", ".restitution_exponent", "1 − e(v) = (1 − e₁)(v/v₁)^q", "e₁ restitution at the speed v₁, q exponent, v speed of approach at first touch"},
    {"velocity_dependent_restitution", ".viscoelastic_time", "F = −A (dF_e/dδ) v_n", "A viscoelastic time, F_e elastic force, δ overlap, v_n normal velocity"},
    {"plastic_contact", ".unloading_ratio", "F = F_e(g (δ − δ₀)) on the way out", "δ overlap, δ₀ = δ_max (1 − 1/g) the dent, g = K^{1/r}, K stiffness of unloading over loading, r exponent of the law"},
    {"plastic_contact", ".yield_pressure", "F = F_y + π p_y R* (δ − δ_y) beyond yield", "p_y yield pressure, R* effective radius, δ overlap"},
    {"nonlinear_stiffness", ".hardening", "F_e → F_e (1 + h δ)", "h hardening, δ overlap"},
    {"nonlinear_stiffness", ".stiffness_power", "F_e → F_e (δ/δ₁)^p", "p change of the exponent, δ overlap, δ₁ reference overlap"},
    {"adhesion", "", "F_pull-off = 3/2 π w R*", "w work of adhesion, R* effective radius; the whole curve is that of Johnson, Kendall & Roberts"},
    {"liquid_bridge", "", "F = −2π R' σ cos θ/(1 + 1.05 s + 2.5 s²), s = S √(R'/V)", "σ surface tension, θ wetting angle, S gap, V volume of the bridge, R' Derjaguin's radius"},
    {"lubrication", "", "F = −6π η R*² v_n/max(h, h₀)", "η viscosity of the film, h gap, h₀ its cut-off, v_n normal velocity"},
    {"wave_loss", "", "u̇ = Y F", "u displacement of the rod's end, Y = 1/(ρ c A) its admittance, F contact force"},
    {"powder_layer", "", "F_e → F_e (1 + n)^{−r}, damping × (1 + n)", "n layers of powder, r exponent of the law"},
    {"sensor_offset", "", "shown = true + b", "b offset"},
    {"sensor_gain", "", "shown = a × true", "a gain"},
    {"sensor_lag", "", "τ dy/dt + y = true", "y what is shown, τ lag"},
    {"clock_shift", "", "shown(t) = true(t − s)", "s shift of the clock"},
    {"saturation", "", "shown = min(true, level)", "either way"},
};

}  // namespace

EffectEquation equation_of(const std::string& effect, const std::vector<std::string>& keys) {
  const Line* found = nullptr;
  for (const Line& line : lines) {
    if (effect != line.effect) continue;
    bool meant = line.key[0] == 0;
    for (const std::string& key : keys) meant |= key.ends_with(line.key);
    if (meant) return {line.equation, line.where};
    if (found == nullptr) found = &line;
  }
  return found != nullptr && keys.empty() ? EffectEquation{found->equation, found->where} : EffectEquation{};
}

}  // namespace quern
