#include "planner/measures/tissue_values.h"

#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>

namespace retractor::planner {

namespace {

    constexpr double kGPa = 1e-3; // of MPa

    /// "120 to 310 N"; "120 N" where both ends read alike.
    std::string range_text(double low, double high, int digits, const char* unit)
    {
        const std::string from = in_words(low, digits), to = in_words(high, digits);
        return (from == to ? from : from + " to " + to) + " " + unit;
    }

    int digits_of(double force_N)
    {
        constexpr double kWhole = 10.0; // N, above which a decimal says nothing
        return force_N < kWhole ? 1 : 0;
    }

    std::string ribs_text(std::span<const BoneStiffness> bones)
    {
        std::size_t ribs = 0, by_image = 0, own = 0;
        double low = 0.0, high = 0.0;
        for (const BoneStiffness& bone : bones) {
            if (bone.material != "bone")
                continue;
            low = ribs == 0 ? bone.modulus_MPa : std::min(low, bone.modulus_MPa);
            high = std::max(high, bone.modulus_MPa);
            ++ribs;
            by_image += bone.origin == StiffnessOrigin::image ? 1U : 0U;
            own += bone.origin == StiffnessOrigin::own ? 1U : 0U;
        }
        if (ribs == 0)
            return {};
        const std::string how = own > 0 ? "the case's own value"
            : by_image == 0             ? "middle of the published range"
                                        : formatted("%zu of %zu by their sections in the CT", by_image, ribs);
        return "ribs " + range_text(kGPa * low, kGPa * high, 1, "GPa") + " (" + how + ")";
    }

} // namespace

std::vector<BoneStiffness> bones_in_wall(std::span<const BoneStiffness> bones, std::span<const Label> in_wall)
{
    std::vector<BoneStiffness> met;
    for (const BoneStiffness& bone : bones)
        if (std::find(in_wall.begin(), in_wall.end(), bone.label) != in_wall.end())
            met.push_back(bone);
    return met;
}

std::string cut_off_text(std::span<const BoneStiffness> bones)
{
    std::vector<std::string> names;
    for (const BoneStiffness& bone : bones)
        if (bone.cut_off_MPa)
            names.push_back(readable(bone.name) + formatted(" (%.1f GPa)", kGPa * *bone.cut_off_MPa));
    if (names.empty())
        return {};
    return formatted("by the CT the bending stiffness lies beyond the %g to %g GPa of tested ribs and is cut off: ",
               kGPa * kSoftestRibMPa, kGPa * kStiffestRibMPa)
        + joined(names);
}

std::string bone_stiffness_text(const FieldMetrics& field)
{
    std::vector<std::string> parts;
    if (std::string ribs = ribs_text(field.bone_stiffness); !ribs.empty())
        parts.push_back(std::move(ribs));
    for (const BoneStiffness& bone : field.bone_stiffness)
        if (bone.material != "bone")
            parts.push_back(readable(bone.name) + formatted(" %.3g MPa (", bone.modulus_MPa)
                + std::string(to_string(bone.origin)) + ")");
    return joined(parts);
}

std::vector<std::string> deciding_parameters(const ParameterInterval& interval)
{
    constexpr double kLeastShare = 0.1;
    constexpr std::size_t kMost = 3;
    const auto influence = [](const ParameterInfluence& p) {
        const double spread = p.low > 0.0 && p.high > 0.0 ? 0.5 * std::log(p.high / p.low) : 0.0;
        return spread * spread * (p.force_exponent * p.force_exponent + p.opening_exponent * p.opening_exponent);
    };
    double sum = 0.0;
    for (const ParameterInfluence& parameter : interval.parameters)
        sum += influence(parameter);
    std::vector<std::string> names;
    for (const ParameterInfluence& parameter : interval.parameters)
        if (names.size() < kMost && sum > 0.0 && influence(parameter) >= kLeastShare * sum)
            names.push_back(parameter.name);
    return names;
}

std::string parameter_text(const FieldMetrics& field)
{
    if (!field.parameters)
        return {};
    const ParameterInterval& interval = *field.parameters;
    if (!interval.message.empty())
        return "no interval from tissue values: " + interval.message;
    std::string text = "tissue values: force "
        + range_text(interval.force_low_N, interval.force_high_N, digits_of(interval.force_high_N), "N") + ", opening "
        + range_text(interval.opening_low_mm, interval.opening_high_mm, 1, "mm");
    if (const std::vector<std::string> names = deciding_parameters(interval); !names.empty())
        text += "; decided by " + joined(names);
    return text;
}

std::string force_with_intervals(const FieldMetrics& field)
{
    if (!field.parameters || !field.parameters->message.empty())
        return {};
    const ParameterInterval& interval = *field.parameters;
    const int digits = digits_of(field.hook_force_N);
    std::string text = in_words(field.hook_force_N, digits) + " N";
    if (field.error && field.error->message.empty())
        text += "; mesh: +- " + in_words(field.error->hook_force_N, digits) + " N";
    text += "; tissue values: " + range_text(interval.force_low_N, interval.force_high_N, digits, "N");
    if (const std::vector<std::string> names = deciding_parameters(interval); !names.empty())
        text += "; decided by " + joined(names);
    return text;
}

} // namespace retractor::planner
