#pragma once
// Quasi-linear viscoelasticity of the force that holds a wound open. Units N, s.
//
// A wound that is held open resists with a force that falls from the last turn of the crank on. Fung's law (Y. C. Fung,
// Biomechanics: Mechanical Properties of Living Tissues, 2nd ed. 1993, ch. 7.6) for the force as a whole is
//   F(t) = integral of G(t - s) dF_e(s),
// with the elastic force F_e that the wound would have without delay, and the reduced relaxation function G, G(0) = 1.
// G is a Prony series: G(t) = g_inf + sum of g_i exp(-t / tau_i).

#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

struct PronyTerm {
    double share = 0.0; ///< g_i, 0 to 1
    double time_s = 0.0; ///< tau_i, above 0
};

/// A reduced relaxation function.
struct Relaxation {
    double long_term = 1.0; ///< g_inf, 0 to 1: the share that never relaxes
    std::vector<PronyTerm> terms {};
    std::string source {}; ///< a publication, and what is ours
};

/// @param where put before the failing key in InputError::where()
/// @throws InputError on NaN, values out of range, and shares whose sum is not 1
void check_relaxation(const Relaxation& relaxation, const std::string& where = {});

/// G at a time after a step. @pre time_s >= 0 and check_relaxation() accepts the relaxation, here and below
double reduced_relaxation(const Relaxation& relaxation, double time_s);

/// A sudden rise of the elastic force.
struct ForceStep {
    double at_s = 0.0;
    double elastic_N = 0.0; ///< rise of the elastic force
};

/// Force at a time after steps: the sum of what is left of each step that has been made. A step at this very time
/// counts.
double stepped_force(const Relaxation& relaxation, std::span<const ForceStep> steps, double time_s);

/// Force at a time of a ramp from 0 s to `ramp_s` up to the elastic force, which is held afterwards:
/// F(t) = F_e / T (g_inf m + sum of g_i tau_i exp(-(t - m) / tau_i) (1 - exp(-m / tau_i))), m = min(t, T).
/// @pre ramp_s >= 0; 0 is a step
double ramp_force(const Relaxation& relaxation, double elastic_N, double ramp_s, double time_s);

/// A published retraction that was opened and then held. Means and standard deviations between animals.
struct PublishedRetraction {
    std::string what {};
    double opening_mm = 0.0, opened_in_s = 0.0;
    double peak_N = 0.0, peak_deviation_N = 0.0; ///< largest force while opening
    double held_N = 0.0, held_deviation_N = 0.0; ///< at full retraction
    std::string source {};
};

/// The table from which chest_wall_relaxation() was fitted.
std::span<const PublishedRetraction> published_retractions();

/// Relaxation of an opened chest wall, fitted by us to published_retractions().
const Relaxation& chest_wall_relaxation();

/// Relative standard deviation, between animals, of the held force at a given peak: root mean square over the table of
/// what follows if peak and held force vary independently. If the two vary together the deviation is smaller.
double held_deviation();

} // namespace retractor::planner
