#include "planner/case/plausible_input.h"

#include "fem/material/hyperelasticity.h"
#include "fem/material/material.h"
#include "fem/material/plausible_modulus.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

namespace retractor::planner {

namespace {

    /// A unit that a number may have been written in by mistake.
    struct MistakenUnit {
        const char* name;
        double size; ///< one of it, in the unit of the range
    };
    constexpr MistakenUnit kStresses[] = { { "kPa", 1e-3 }, { "GPa", 1e3 }, { "Pa", 1e-6 } };
    constexpr MistakenUnit kImageLengths[] = { { "m", 1e3 }, { "cm", 10.0 }, { "µm", 1e-3 } };
    constexpr MistakenUnit kLengths[] = { { "m", 1e3 }, { "cm", 10.0 } }; // nobody gives an incision in µm
    constexpr MistakenUnit kPressures[]
        = { { "mmHg", 0.133322 }, { "Pa", 1e-3 }, { "cmH2O", 0.0980665 }, { "MPa", 1e3 } };
    constexpr MistakenUnit kForces[] = { { "kN", 1e3 }, { "mN", 1e-3 } };
    constexpr MistakenUnit kGrips[] = { { "N/m", 1e-3 }, { "kN/mm", 1e3 } };
    constexpr MistakenUnit kShares[] = { { "%", 1e-2 } };

    struct PlausibleRange {
        double least = 0.0, most = 0.0;
        const char* unit = ""; ///< with a space before it
        std::span<const MistakenUnit> mistaken {};
    };
    // Skin is stretched by 0.02 to 0.06 in the body (docs/method/elasticity.md); five times as much is ours.
    constexpr PlausibleRange kPreStrain { 0.0, 0.3, "", kShares };
    // No tissue of a chest wall grows wider when it is stretched; below the solvers' limit of 0.5 (ours).
    constexpr PlausibleRange kPoissonsRatio { 0.0, 0.5, "", kShares };
    // A drain sucks with up to 27 kPa (200 mmHg), and no artery bears more than 40 kPa (300 mmHg) for long (ours).
    constexpr PlausibleRange kPressure { -30.0, 40.0, " kPa", kPressures };
    // From a stab for a port to an incision round the whole of one side (ours).
    constexpr PlausibleRange kIncision { 5.0, 800.0, " mm", kLengths };
    // From the skin alone to through a very stout wall (ours).
    constexpr PlausibleRange kDepth { 1.0, 400.0, " mm", kLengths };
    // Spreaders open 50 to 112 mm (Chanoit 2019, Aigner 2013). A hook moves half of it, and here up to 125 mm. The
    // least motion is ours: openings below 0.2 mm are not seen.
    constexpr PlausibleRange kHookMotion { 0.1, 125.0, " mm", kLengths };
    // Largest forces on a side: 118 to 470 N (Chanoit 2019, doi 10.1186/s12938-019-0664-z), 349 +- 78 N (Aigner 2013,
    // doi 10.1016/j.jtcvs.2013.07.075); twice as much is ours, and so is the least.
    constexpr PlausibleRange kHookForce { 0.01, 1000.0, " N", kForces };
    // A wall resists a hook with some 10 N/mm; a thousandth and a hundredfold are ours.
    constexpr PlausibleRange kGrip { 0.01, 1000.0, " N/mm", kGrips };
    // From a loupe to the far side of the theatre (ours).
    constexpr PlausibleRange kEyeDistance { 20.0, 5000.0, " mm", kLengths };
    /// A law is checked by its stiffness at small strain, which may be tenfold softer than the modulus of retraction.
    constexpr double kLawSpread = 10.0;
    /// The longest side of an image. A body in cm is 30 to 45 long; the smallest test image is 60 mm (ours).
    constexpr double kShortestImageMm = 50.0, kLongestImageMm = 3000.0;

    bool lies_in(const PlausibleRange& range, double value) { return value >= range.least && value <= range.most; }

    /// "look at the number and its unit", or the unit that makes the number plausible.
    std::string question(const PlausibleRange& range, double value)
    {
        for (const MistakenUnit& unit : range.mistaken)
            if (lies_in(range, value * unit.size))
                return std::string("is it in ") + unit.name + formatted(" (%.6g", value * unit.size) + range.unit
                    + ")?";
        return "look at the number and its unit";
    }

    /// The findings, in the order of the file.
    class Findings {
    public:
        void check(double value, const PlausibleRange& range, const std::string& what, const std::string& pointer)
        {
            if (lies_in(range, value))
                return;
            found_.push_back({ pointer,
                what + formatted(" is %.6g", value) + range.unit + formatted(", and %g to %g", range.least, range.most)
                    + range.unit + " is plausible: " + question(range, value) });
        }
        std::vector<ImplausibleValue> take() { return std::move(found_); }

    private:
        std::vector<ImplausibleValue> found_;
    };

    void check_material(Findings& findings, const fem::Material& material, const std::string& pointer)
    {
        const fem::ModulusRange modulus = fem::plausible_modulus(material.name);
        const PlausibleRange range { modulus.least, modulus.most, " MPa", kStresses };
        findings.check(material.youngs_modulus_MPa, range, "the Young's modulus of " + material.name,
            pointer + "/youngs_modulus_MPa");
        findings.check(material.poissons_ratio, kPoissonsRatio, "Poisson's ratio of " + material.name,
            pointer + "/poissons_ratio");
        if (material.law) {
            const double shear = fem::small_strain_moduli(fem::hyperelastic_law(material)).mu;
            // An incompressible solid's Young's modulus is three times its shear modulus.
            findings.check(3.0 * shear, { modulus.least / kLawSpread, modulus.most * kLawSpread, " MPa", kStresses },
                "the Young's modulus at small strain of the law of " + material.name, pointer + "/law");
        }
        if (material.pre_strain.kind != fem::PreStrainKind::none) {
            findings.check(material.pre_strain.strain, kPreStrain, "the tension of " + material.name,
                pointer + "/pre_strain/along");
            findings.check(material.pre_strain.across, kPreStrain, "the tension across of " + material.name,
                pointer + "/pre_strain/across");
        }
    }

    void check_hook(Findings& findings, const HookSpec& hook, const std::string& pointer)
    {
        const std::string of_hook = " of the hook \"" + hook.name + "\"";
        if (hook.opening_mm != 0.0) // a hook that pulls with a force has no motion of its own
            findings.check(hook.opening_mm, kHookMotion, "the motion" + of_hook, pointer + "/opening_mm");
        if (hook.pull.force_N)
            findings.check(*hook.pull.force_N, kHookForce, "the force" + of_hook, pointer + "/force_N");
        if (hook.pull.force_limit_N)
            findings.check(
                *hook.pull.force_limit_N, kHookForce, "the force limit" + of_hook, pointer + "/force_limit_N");
        if (hook.pull.grip_N_per_mm)
            findings.check(*hook.pull.grip_N_per_mm, kGrip, "the grip" + of_hook, pointer + "/grip_N_per_mm");
    }

    void refuse_unless_accepted(const Case& planned_case, std::span<const ImplausibleValue> found)
    {
        if (planned_case.accept_implausible || found.empty())
            return;
        throw InputError(found.front().text
                + (found.size() > 1 ? "; " + std::to_string(found.size() - 1) + " more number(s) are implausible" : "")
                + "; if the number is right, set \"accept_implausible\" of the case to true",
            found.front().pointer, { "accept_implausible" });
    }

} // namespace

std::vector<ImplausibleValue> find_implausible(const Case& planned_case)
{
    Findings findings;
    for (std::size_t n = 0; n < planned_case.materials.size(); ++n)
        check_material(findings, planned_case.materials[n], "/materials/" + std::to_string(n));
    for (std::size_t n = 0; n < planned_case.pressures.size(); ++n)
        findings.check(planned_case.pressures[n].pressure_kPa, kPressure,
            "the pressure of " + planned_case.pressures[n].label, "/pressures/" + std::to_string(n) + "/pressure_kPa");
    return findings.take();
}

std::vector<ImplausibleValue> find_implausible(const Approach& approach, const std::string& pointer)
{
    Findings findings;
    findings.check(incision_length(approach), kIncision, "the length of the incision", pointer + "/incision_mm");
    findings.check(approach.depth_mm, kDepth, "the depth of the cut", pointer + "/depth_mm");
    for (std::size_t h = 0; h < approach.hooks.size(); ++h)
        check_hook(findings, approach.hooks[h], pointer + "/hooks/" + std::to_string(h));
    findings.check(
        approach.view.eye_distance_mm, kEyeDistance, "the distance of the eyes", pointer + "/view/eye_distance_mm");
    return findings.take();
}

void check_plausible(const Case& planned_case)
{
    std::vector<ImplausibleValue> found = find_implausible(planned_case);
    for (std::size_t n = 0; n < planned_case.approaches.size(); ++n)
        std::ranges::move(find_implausible(planned_case.approaches[n], "/approaches/" + std::to_string(n)),
            std::back_inserter(found));
    refuse_unless_accepted(planned_case, found);
}

void check_plausible(const Case& planned_case, const Approach& approach, const std::string& pointer)
{
    refuse_unless_accepted(planned_case, find_implausible(approach, pointer));
}

std::optional<std::string> implausible_extent(const mesh::ImageGrid& grid)
{
    std::array<double, 3> sides {};
    for (int axis = 0; axis < 3; ++axis)
        sides.at(static_cast<std::size_t>(axis)) = grid.size.at(static_cast<std::size_t>(axis)) * grid.spacing[axis];
    const double longest = *std::max_element(sides.begin(), sides.end());
    const PlausibleRange range { kShortestImageMm, kLongestImageMm, " mm", kImageLengths };
    if (lies_in(range, longest))
        return std::nullopt;
    return formatted("the image is %.4g x %.4g x %.4g mm, and a longest side of %g to %g mm is plausible: ", sides[0],
               sides[1], sides[2], range.least, range.most)
        + question(range, longest);
}

} // namespace retractor::planner
