#include "planner/plan/parameter_interval.h"

#include "fem/statics/parameter_sensitivity.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/stiffness_factors.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/wall/rib_joints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr std::string_view kRib = "rib";

    constexpr std::array kRanges {
        PublishedRange { "skin", 0.02, 1.18, "shear wave to the first slope in tension, arXiv 1302.3022" },
        PublishedRange { "fat", 0.005, 0.02, "small to moderate strain" },
        PublishedRange { "muscle", 0.02, 0.1, "0.04 to 0.06 across the fibres, PMC9711973; widened, ours" },
        PublishedRange { "intercostal", 0.1, 0.3, "muscle with its fasciae under retraction" },
        PublishedRange { "bone", kSoftestRibMPa, kStiffestRibMPa, "whole ribs in bending, Pezowicz 2012" },
        PublishedRange { kRib, kSoftestRibMPa, kStiffestRibMPa, "whole ribs in bending, Pezowicz 2012" },
        PublishedRange { "cartilage", kPerichondrium* kSoftestCartilageMPa, kPerichondrium* kStiffestCartilageMPa,
            "substance 5 to 25 MPa, with perichondrium, Forman 2010" },
        // 0.2 N m over 20.9 and over 6.4 degrees, N m/rad.
        PublishedRange {
            kJointSprings, 0.548, 1.790, "turns by 6.4 to 20.9 degrees, Lebschy 2024, J Biomech 163:111923" },
        PublishedRange { kGirdleSprings, 1.0 / 3.0, 3.0, "a factor of 3 to either side, ours" },
    };

    struct Parameter {
        fem::StiffnessParameter members;
        ParameterInfluence influence;
    };

    /// Half the logarithm of a range, as a factor about the value.
    void set_range(ParameterInfluence& influence, double factor)
    {
        influence.low = influence.value / factor;
        influence.high = influence.value * factor;
    }

    double half_range(double low, double high) { return std::sqrt(high / low); }

    /// Ribs and cartilages with moduli of their own: their geometric mean and the mean of their ranges.
    void take_bones(ParameterInfluence& influence, const std::vector<Label>& labels,
        std::span<const BoneStiffness> bones, const PublishedRange& published)
    {
        double value = 0.0, range = 0.0;
        std::size_t count = 0, own = 0;
        for (const BoneStiffness& bone : bones) {
            if (std::find(labels.begin(), labels.end(), bone.label) == labels.end())
                continue;
            value += std::log(bone.modulus_MPa);
            const bool has_range = bone.high_MPa > bone.low_MPa;
            own += has_range ? 0U : 1U;
            range += std::log(
                has_range ? half_range(bone.low_MPa, bone.high_MPa) : half_range(published.low, published.high));
            ++count;
        }
        if (count == 0)
            return;
        influence.value = std::exp(value / static_cast<double>(count));
        set_range(influence, std::exp(range / static_cast<double>(count)));
        if (own == 0 && std::any_of(bones.begin(), bones.end(), [&](const BoneStiffness& bone) {
                return bone.origin == StiffnessOrigin::image
                    && std::find(labels.begin(), labels.end(), bone.label) != labels.end();
            }))
            influence.source += "; by the patient's CT, see bone_stiffness";
    }

    /// One parameter per material of the wall; ribs count apart from other bones.
    std::vector<Parameter> tissue_parameters(
        const PlannedField& field, const mesh::LabelTable& table, std::span<const BoneStiffness> bones)
    {
        std::vector<Parameter> parameters;
        for (const Label label : fem::labels_met(field.problem.mesh)) {
            const mesh::LabelInfo* info = mesh::find_label(table, label);
            const fem::Material& material = field.problem.material_of_label[label];
            const std::string name
                = info != nullptr && material.name == "bone" && is_rib(info->name) ? std::string(kRib) : material.name;
            auto same = std::find_if(
                parameters.begin(), parameters.end(), [&](const Parameter& p) { return p.members.name == name; });
            if (same == parameters.end()) {
                Parameter parameter { .members = { .name = name }, .influence = {} };
                parameter.influence.name = name;
                parameter.influence.unit = "MPa";
                parameter.influence.value = material.youngs_modulus_MPa;
                const PublishedRange published = published_range(name);
                set_range(parameter.influence, half_range(published.low, published.high));
                parameter.influence.source = published.source;
                parameters.push_back(std::move(parameter));
                same = parameters.end() - 1;
            }
            same->members.labels.push_back(label);
        }
        for (Parameter& parameter : parameters)
            take_bones(parameter.influence, parameter.members.labels, bones, published_range(parameter.members.name));
        return parameters;
    }

    /// The springs and hinges of the ribs' joints, and the springs under the shoulder girdle.
    std::vector<Parameter> spring_parameters(const PlannedField& field, const mesh::LabelTable& table)
    {
        const std::vector<std::uint8_t> on_rib = vertices_on_ribs(field.problem.mesh, table);
        const auto parameter_of = [](std::string_view name, const char* unit, double value) {
            Parameter parameter { .members = { .name = std::string(name) }, .influence = {} };
            parameter.influence.name = name;
            parameter.influence.unit = unit;
            parameter.influence.value = value;
            const PublishedRange published = published_range(name);
            set_range(parameter.influence, half_range(published.low, published.high));
            parameter.influence.source = published.source;
            return parameter;
        };
        constexpr double kNmPerNmm = 1e-3;
        std::vector<Parameter> parameters { parameter_of(kJointSprings, "N m/rad", kNmPerNmm * kJointNmm_per_rad),
            parameter_of(kGirdleSprings, "1", 1.0) };
        const std::vector<fem::BeddedVertex>& bedded = field.problem.supports.bedded;
        for (std::size_t i = 0; i < bedded.size(); ++i)
            parameters[on_rib[static_cast<std::size_t>(bedded[i].vertex)] != 0 ? 0 : 1].members.springs.push_back(i);
        for (std::size_t i = 0; i < field.problem.supports.hinges.size(); ++i)
            parameters.front().members.hinges.push_back(i);
        std::erase_if(
            parameters, [](const Parameter& p) { return p.members.springs.empty() && p.members.hinges.empty(); });
        return parameters;
    }

    std::optional<fem::EquilibriumSensitivity> differentiate(const PlannedField& field, const OpenedWound& wound,
        const SolverSettings& choice, const std::vector<Parameter>& parameters, const Eigen::VectorXd& solved)
    {
        const fem::ElasticProblem& problem = field.problem;
        std::vector<fem::StiffnessParameter> members;
        for (const Parameter& parameter : parameters)
            members.push_back(parameter.members);
        const fem::TissueModel model { choice.elasticity, choice.element == ElementKind::locking_free };
        const Points displacement = Eigen::Map<const Points>(solved.data(), solved.size() / 3, 3);
        const Eigen::MatrixXd motions = field.retractor
            ? fem::blade_motions(problem.mesh, problem.hooks)
            : fem::hook_motions(fem::prescribe(problem.mesh, problem.supports, problem.hooks), problem.hooks.size());
        const fem::ParameterSensitivity sensitivity
            = fem::parameter_sensitivity(problem, model, displacement, members, motions, wound.contact);
        if (field.retractor)
            return fem::with_balanced_frame(problem, sensitivity,
                { .frame = field.retractor->frame,
                    .state = field.retractor->state,
                    .loads = field.retractor->loads,
                    .driven_by_force = field.approach.retractor->force_N.has_value(),
                    .direction_is_held = field.retractor->direction_is_held });
        const std::vector<fem::HookDrive> drives = drives_of(field.approach);
        if (drives.empty())
            return fem::with_held_hooks(problem, sensitivity);
        std::vector<Vec3> at;
        for (const fem::HookPatch& hook : problem.hooks)
            at.push_back(hook.displacement);
        return fem::with_driven_hooks(
            problem, sensitivity, fem::packed(at), fem::packed(field.opening.hook_forces_N), drives);
    }

    /// Sets the exponents from the derivatives of opening and force, by a small step to either side.
    void set_exponents(ParameterInfluence& influence, const PlannedField& field, const OpenedWound& wound,
        const Eigen::VectorXd& solved, const Eigen::VectorXd& moved, const Eigen::VectorXd& forces)
    {
        constexpr double kStepMm = 0.05, kLargestStep = 0.1; // within it, the same places of the lips are measured
        const double largest = moved.size() == 0 ? 0.0 : moved.cwiseAbs().maxCoeff();
        const double step = largest > 0.0 ? std::min(kLargestStep, kStepMm / largest) : kLargestStep;
        const Eigen::VectorXd own = fem::packed(field.opening.hook_forces_N);
        const auto measured = [&](double way) {
            const Eigen::VectorXd there = solved + way * moved;
            Points displacement
                = Eigen::Map<const Points>(there.data(), there.size() / 3, 3).topRows(field.wall.vertices.rows());
            return measures_of(field, wound.rigid, displacement, fem::per_hook(Eigen::VectorXd(own + way * forces)));
        };
        const WoundMeasures here = measures_of(field), more = measured(step), less = measured(-step);
        const std::size_t side = here.side_N[0] >= here.side_N[1] ? 0 : 1;
        if (here.width_mm > 0.0)
            influence.opening_exponent = (more.width_mm - less.width_mm) / (2.0 * step * here.width_mm);
        if (here.side_N[side] > 0.0)
            influence.force_exponent = (more.side_N[side] - less.side_N[side]) / (2.0 * step * here.side_N[side]);
    }

} // namespace

PublishedRange published_range(std::string_view name)
{
    const auto known
        = std::find_if(kRanges.begin(), kRanges.end(), [&](const PublishedRange& r) { return r.name == name; });
    return known != kRanges.end() ? *known : PublishedRange { name, 0.5, 2.0, "a factor of 2 to either side, ours" };
}

ParameterInterval combine_parameters(double force_N, double opening_mm, std::vector<ParameterInfluence> parameters)
{
    double of_force = 0.0, of_opening = 0.0; // variances of the logarithms
    const auto deviation = [](const ParameterInfluence& p) { return 0.5 * std::log(p.high / p.low); };
    for (ParameterInfluence& parameter : parameters) {
        const std::string where = "parameter '" + parameter.name + "'";
        if (!(parameter.low > 0.0 && parameter.high >= parameter.low && std::isfinite(parameter.high)))
            throw InputError(
                formatted("the range from %g to %g is not a range of a stiffness", parameter.low, parameter.high),
                where);
        if (!std::isfinite(parameter.force_exponent) || !std::isfinite(parameter.opening_exponent))
            throw InputError("an exponent is not finite", where);
        const double sigma = deviation(parameter);
        const double force = parameter.force_exponent * sigma, opening = parameter.opening_exponent * sigma;
        of_force += force * force;
        of_opening += opening * opening;
        parameter.force_change_percent = 100.0 * std::expm1(force);
        parameter.opening_change_percent = 100.0 * std::expm1(opening);
    }
    const auto influence
        = [&](const ParameterInfluence& p) { return deviation(p) * std::hypot(p.force_exponent, p.opening_exponent); };
    std::stable_sort(parameters.begin(), parameters.end(),
        [&](const ParameterInfluence& a, const ParameterInfluence& b) { return influence(a) > influence(b); });
    const double force = std::exp(std::sqrt(of_force)), opening = std::exp(std::sqrt(of_opening));
    return { .force_low_N = force_N / force,
        .force_high_N = force_N * force,
        .opening_low_mm = opening_mm / opening,
        .opening_high_mm = opening_mm * opening,
        .parameters = std::move(parameters) };
}

std::optional<ParameterInterval> estimate_parameter_interval(const PlannedField& field, const OpenedWound& wound,
    const SolverSettings& choice, const mesh::LabelTable& table, std::span<const BoneStiffness> bones)
{
    if (field.hooks.empty())
        return std::nullopt;
    if (!is_usable(field.opening))
        return ParameterInterval { .message = "the wound did not open as requested" };
    if (has_condensed_region(field))
        return ParameterInterval { .message = "the tissue far from the lips was computed as linear; plan without a "
                                              "linear region" };
    const Stopwatch watch;
    ParameterInterval interval;
    try {
        std::vector<Parameter> parameters = tissue_parameters(field, table, bones);
        for (Parameter& springs : spring_parameters(field, table))
            parameters.push_back(std::move(springs));
        const Eigen::VectorXd solved = displacement_at_nodes(field, wound);
        const std::optional<fem::EquilibriumSensitivity> change
            = differentiate(field, wound, choice, parameters, solved);
        if (!change)
            return ParameterInterval { .message = "the hooks have no equilibrium in the linearised tissue" };
        std::vector<ParameterInfluence> influences;
        for (std::size_t p = 0; p < parameters.size(); ++p) {
            const auto column = static_cast<Eigen::Index>(p);
            set_exponents(parameters[p].influence, field, wound, solved, change->displacement.col(column),
                change->hook_forces_N.col(column));
            influences.push_back(std::move(parameters[p].influence));
        }
        const WoundMeasures here = measures_of(field);
        interval = combine_parameters(here.larger_side_N(), here.width_mm, std::move(influences));
    } catch (const Error& error) {
        interval = { .message = error.what() };
    }
    interval.seconds = watch.seconds();
    return interval;
}

} // namespace retractor::planner
