#include "planner/measures/bones/bone_limits.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"
#include "planner/anatomy/rib_name.h"
#include "planner/measures/ball_strain.h"
#include "planner/measures/hook_opening.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace retractor::planner {

namespace {

    // Middles of the parts of a rib round the chest; between them the capacity is linear.
    constexpr double kPosteriorDeg = 45.0, kLateralDeg = 90.0, kAnteriorDeg = 135.0;
    /// Openings are told to whole millimetres, rounded down.
    constexpr double kWholeMm = 1.0;

    double between(double from, double to, double share) { return from + std::clamp(share, 0.0, 1.0) * (to - from); }

    double section_factor(double section_mm2)
    {
        return std::clamp(
            std::pow(section_mm2 / kTestedRibAreaMm2, 1.5), kSmallestSectionFactor, kLargestSectionFactor);
    }

    std::string part_of_rib(double angle_deg)
    {
        if (angle_deg < 0.5 * (kPosteriorDeg + kLateralDeg))
            return "posterior";
        return angle_deg < 0.5 * (kLateralDeg + kAnteriorDeg) ? "lateral" : "anterior";
    }

    /// A rib from the spine on, a sternum from its upper end down.
    BoneBar in_order(const BoneBar& bar, bool rib, const AnatomicalFrame& frame)
    {
        const Vec3 first = bar.sections.front().centre, last = bar.sections.back().centre;
        const bool turn = rib ? angle_round_chest_deg(frame, first) > angle_round_chest_deg(frame, last)
                              : frame.superior.dot(first - last) < 0.0;
        return turn ? reversed(bar) : bar;
    }

    BoneMetrics metrics_of(
        const std::string& name, const BoneBar& bar, const BoneSection& section, const AnatomicalFrame& frame)
    {
        BoneMetrics bone { .name = name,
            .at_mm = section.at_mm,
            .length_mm = bar.length_mm,
            .place = section.centre,
            .section_mm2 = section.area_mm2,
            .bending_Nm = section.bending_Nm,
            .torsion_Nm = section.torsion_Nm,
            .moment_Nm = equivalent_moment_Nm(section.bending_Nm, section.torsion_Nm) };
        if (!is_rib(name))
            return bone;
        const double angle = angle_round_chest_deg(frame, section.centre);
        bone.part = part_of_rib(angle);
        bone.capacity_Nm = rib_capacity_Nm(angle, section.area_mm2);
        bone.utilisation = bone.moment_Nm / *bone.capacity_Nm;
        return bone;
    }

    /// Whether `a` is loaded more than `b`: by utilisation, then by moment.
    bool is_worse(const BoneMetrics& a, const BoneMetrics& b)
    {
        return a.utilisation != b.utilisation ? a.utilisation > b.utilisation : a.moment_Nm > b.moment_Nm;
    }

    std::string rough_text(const FieldMetrics& field)
    {
        return field.bones_rough ? " The elements of this mesh are too stiff, so these moments are rough." : "";
    }

    std::string uninjured_text(const FieldMetrics& field)
    {
        const double opening = kWholeMm * std::floor(*field.largest_uninjured_opening_mm / kWholeMm);
        if (!is_uninjured_opening_solved(field))
            return formatted(" The largest opening without a fracture is about %.0f mm (estimate).", opening);
        const UninjuredOpening& solved = *field.uninjured_opening;
        return formatted(" The largest opening without a fracture is %.0f mm (solved), with %.0f N on the larger side; "
                         "%s then bears %.0f %% of what tested ribs bore.",
            opening, solved.hook_force_N, bone_in_words(solved.bone).c_str(), 100.0 * solved.utilisation);
    }

    std::string place_text(const BoneMetrics& bone)
    {
        return formatted("in its %s part, %.0f mm from the spine", bone.part.c_str(), bone.at_mm);
    }

} // namespace

bool is_rib(std::string_view label) { return label.starts_with("rib_left_") || label.starts_with("rib_right_"); }

bool is_long_bone(std::string_view label) { return is_rib(label) || label == "sternum"; }

double angle_round_chest_deg(const AnatomicalFrame& frame, const Vec3& point)
{
    const Vec3 from_origin = point - frame.origin;
    return std::atan2(std::abs(frame.left.dot(from_origin)), -frame.anterior.dot(from_origin)) * 180.0
        / std::numbers::pi;
}

double rib_capacity_Nm(double angle_deg, double section_mm2)
{
    const double mean = angle_deg < kLateralDeg
        ? between(kPosteriorRibNm, kLateralRibNm, (angle_deg - kPosteriorDeg) / (kLateralDeg - kPosteriorDeg))
        : between(kLateralRibNm, kAnteriorRibNm, (angle_deg - kLateralDeg) / (kAnteriorDeg - kLateralDeg));
    return mean * section_factor(section_mm2);
}

double equivalent_moment_Nm(double bending_Nm, double torsion_Nm)
{
    return 0.5 * (std::abs(bending_Nm) + std::hypot(bending_Nm, torsion_Nm));
}

BoneMetrics bone_limit(const std::string& name, std::span<const BoneBar> pieces, const AnatomicalFrame& frame)
{
    std::optional<BoneMetrics> worst;
    for (const BoneBar& piece : pieces) {
        if (piece.sections.empty())
            continue;
        const BoneBar bar = in_order(piece, is_rib(name), frame);
        for (const BoneSection& section : bar.sections)
            if (BoneMetrics here = metrics_of(name, bar, section, frame); !worst || is_worse(here, *worst))
                worst = std::move(here);
    }
    RETRACTOR_ASSERT(worst.has_value());
    return std::move(*worst);
}

void set_attainable(FieldMetrics& field, bool in_equilibrium)
{
    std::ranges::stable_sort(field.bones, is_worse);
    field.largest_uninjured_opening_mm.reset();
    for (BoneMetrics& bone : field.bones)
        bone.opening_at_limit_mm.reset();
    if (!in_equilibrium) {
        field.attainable = Attainable::no;
        return;
    }
    if (!field.bones_message.empty()) {
        field.attainable = any_would_tear(field) ? Attainable::with_injury : Attainable::unknown;
        return;
    }
    const double reached = hook_opening(field).reached_mm;
    field.attainable = any_would_tear(field) ? Attainable::with_injury : Attainable::yes;
    double largest = reached;
    for (BoneMetrics& bone : field.bones)
        if (bone.utilisation >= 1.0) {
            field.attainable = Attainable::with_injury;
            bone.opening_at_limit_mm = reached / bone.utilisation;
            largest = std::min(largest, *bone.opening_at_limit_mm);
        }
    field.largest_uninjured_opening_mm = largest;
}

bool is_uninjured_opening_solved(const FieldMetrics& field)
{
    return field.uninjured_opening && field.uninjured_opening->message.empty();
}

bool breaks_bone(const FieldMetrics& field)
{
    return std::ranges::any_of(
        field.bones, [](const BoneMetrics& bone) { return bone.opening_at_limit_mm.has_value(); });
}

std::string_view to_string(Attainable attainable)
{
    switch (attainable) {
    case Attainable::yes:
        return "yes";
    case Attainable::with_injury:
        return "with_injury";
    case Attainable::no:
        return "no";
    case Attainable::unknown:
        break;
    }
    return "unknown";
}

std::string capital(std::string text)
{
    if (!text.empty() && text[0] >= 'a' && text[0] <= 'z')
        text[0] = static_cast<char>(text[0] - 'a' + 'A');
    return text;
}

std::string bone_in_words(std::string_view label)
{
    if (const std::optional<RibName> rib = rib_name(label))
        return rib_in_words(*rib);
    return "the " + readable(std::string(label));
}

std::string attainable_text(const FieldMetrics& field)
{
    switch (field.attainable) {
    case Attainable::yes:
        return "yes";
    case Attainable::no:
        return "no";
    case Attainable::unknown:
        return "not known";
    case Attainable::with_injury:
        break;
    }
    std::vector<std::string> injured;
    for (const BoneMetrics& bone : field.bones)
        if (bone.opening_at_limit_mm)
            injured.push_back(bone_in_words(bone.name));
    for (const TissueStrain& tissue : field.tissue_strain)
        if (would_tear(tissue))
            injured.push_back(readable(tissue.tissue));
    return "with injury: " + joined(injured);
}

std::string opening_at_limit_text(const BoneMetrics& bone)
{
    RETRACTOR_ASSERT(bone.opening_at_limit_mm);
    return formatted("%.0f mm", std::floor(*bone.opening_at_limit_mm / kWholeMm) * kWholeMm);
}

std::string bones_text(const FieldMetrics& field)
{
    if (field.attainable == Attainable::no)
        return "The opening is not attainable: the computation found no equilibrium, so the loads of the bones are not "
               "given.";
    if (!field.bones_message.empty())
        return "Whether a bone would break is not known: " + field.bones_message + ".";
    if (field.bones.empty())
        return {};
    const BoneMetrics& bone = field.bones.front();
    if (!bone.capacity_Nm)
        return formatted("The largest moment in %s is %.1f N m; there is no published number for what it bears.",
                   bone_in_words(bone.name).c_str(), bone.moment_Nm)
            + rough_text(field);
    if (!bone.opening_at_limit_mm)
        return formatted(
                   "No rib reaches the moment at which tested ribs broke. %s comes nearest: %.1f N m %s, which is "
                   "%.0f %% of the %.1f N m of tested ribs.",
                   capital(bone_in_words(bone.name)).c_str(), bone.moment_Nm, place_text(bone).c_str(),
                   100.0 * bone.utilisation, *bone.capacity_Nm)
            + rough_text(field);
    std::string text = formatted("%s would break %s, from an opening of about %s on (%.1f N m; tested ribs broke at "
                                 "about %.1f N m).",
        capital(bone_in_words(bone.name)).c_str(), place_text(bone).c_str(), opening_at_limit_text(bone).c_str(),
        bone.moment_Nm, *bone.capacity_Nm);
    std::vector<std::string> others;
    for (const BoneMetrics& other : field.bones)
        if (&other != &bone && other.opening_at_limit_mm)
            others.push_back(bone_in_words(other.name) + " from about " + opening_at_limit_text(other) + " on");
    if (!others.empty())
        text += " Also " + joined(others) + ".";
    return text + uninjured_text(field) + rough_text(field);
}

std::string joints_text(const FieldMetrics& field)
{
    const BoneMetrics* joint = nullptr;
    const BoneMetrics* turned = nullptr;
    const BoneMetrics* cartilage = nullptr;
    for (const BoneMetrics& bone : field.bones) {
        if (bone.spine_joint && (joint == nullptr || bone.spine_joint->force_N > joint->spine_joint->force_N))
            joint = &bone;
        if (bone.spine_joint && bone.spine_joint->turn_deg
            && (turned == nullptr || *bone.spine_joint->turn_deg > *turned->spine_joint->turn_deg))
            turned = &bone;
        if (bone.cartilage && (cartilage == nullptr || bone.cartilage->force_N > cartilage->cartilage->force_N))
            cartilage = &bone;
    }
    std::string text;
    if (joint != nullptr)
        text = formatted("The joint with the spine that bears most is that of %s, with %.0f N and %.1f N m.",
            bone_in_words(joint->name).c_str(), joint->spine_joint->force_N, joint->spine_joint->moment_Nm);
    if (turned != nullptr)
        text += formatted(" The rib that turns most about its joints is %s, by %.1f degrees%s.",
            bone_in_words(turned->name).c_str(), *turned->spine_joint->turn_deg,
            turned->spine_joint->at_stop ? ", beyond its stop" : "");
    if (cartilage != nullptr)
        text += formatted("%sThe cartilage that bears most is that of %s, with %.0f N and %.1f N m.",
            text.empty() ? "" : " ", bone_in_words(cartilage->name).c_str(), cartilage->cartilage->force_N,
            cartilage->cartilage->moment_Nm);
    return text.empty() ? text : text + " There is no published number for what joint and cartilage bear.";
}

} // namespace retractor::planner
