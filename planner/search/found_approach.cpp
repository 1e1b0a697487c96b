#include "planner/search/found_approach.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/approach_templates.h"
#include "planner/search/aperture_score.h"
#include "planner/search/held_open.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace retractor::planner {

namespace {

    Vec3 middle_of(const Approach& approach)
    {
        return incision_place(approach, 0.5 * incision_length(approach)).of(approach.incision);
    }

    /// Refuses an approach that has slid away from the incision that was found, or has become shorter.
    void check_is_found(const Approach& approach, const FoundIncision& incision)
    {
        constexpr double kAwayMm = 8.0, kShorter = 0.93;
        const double length = incision_length(approach);
        if (length < kShorter * incision.length_mm)
            throw InputError("the blade has room for " + in_words(std::round(length)) + " mm only");
        const double away = (middle_of(approach) - incision.middle).norm();
        if (away > kAwayMm)
            throw InputError("the blade has room only " + in_words(std::round(away)) + " mm away");
    }

    /// The template's incision, moved along the space until its middle is that of the incision that was found.
    Approach in_space(Patient& patient, const FoundIncision& incision, ApproachRequest request)
    {
        constexpr int kCorrections = 3;
        constexpr double kSameMm = 1.0;
        request.template_name = "intercostal:" + std::to_string(incision.space->number);
        request.left = incision.space->left;
        request.length_mm = incision.length_mm;
        Approach approach = approach_from_template(*patient.labels(), *patient.anatomy(), request);
        for (int n = 0; n < kCorrections; ++n) {
            const Vec3 off = incision.middle - middle_of(approach);
            const Vec3 forwards = (approach.incision.back() - approach.incision.front()).normalized();
            if (std::abs(off.dot(forwards)) < kSameMm)
                break;
            request.shift_mm += off.dot(forwards) > 0.0 ? off.norm() : -off.norm();
            approach = approach_from_template(*patient.labels(), *patient.anatomy(), request);
        }
        check_is_found(approach, incision);
        return approach;
    }

    std::string name_of(const FoundIncision& incision)
    {
        if (incision.kind == FoundIncision::Kind::sternum)
            return "median";
        const std::string length = std::to_string(std::lround(incision.length_mm)) + "mm";
        return incision.space ? std::string(incision.space->left ? "left" : "right") + "_space_"
                + std::to_string(incision.space->number) + "_" + length
                              : "incision_" + length;
    }

    ApertureKind kind_of(const FoundIncision& incision)
    {
        switch (incision.kind) {
        case FoundIncision::Kind::space:
            return kind_over(*incision.space);
        case FoundIncision::Kind::sternum:
            return ApertureKind::sternum;
        case FoundIncision::Kind::skin:
            break;
        }
        return ApertureKind::skin;
    }

} // namespace

Approach approach_of(Patient& patient, const FoundIncision& incision, const SearchRequest& request)
{
    ApproachRequest asked;
    asked.name = name_of(incision);
    asked.target = request.target;
    asked.sizing = request.sizing;
    asked.view = request.view;
    Approach approach;
    if (incision.kind == FoundIncision::Kind::space) {
        approach = in_space(patient, incision, asked);
    } else if (incision.kind == FoundIncision::Kind::sternum) {
        asked.template_name = "median";
        approach = approach_from_template(*patient.labels(), *patient.anatomy(), asked);
    } else {
        constexpr std::size_t kEvery = 3; // sections are 8 mm apart
        std::vector<Vec3> points;
        for (std::size_t n = 0; n + 1 < incision.points.size(); n += kEvery)
            points.push_back(incision.points[n]);
        points.push_back(incision.points.back());
        approach = approach_from_points(*patient.labels(), points, asked).approach;
    }
    approach.retracted
        = organs_aside(patient.planned_case().label_table, request.target, kind_of(incision), request.retracted);
    approach.rationale = "Found by a search that started from no template. " + approach.rationale;
    return opened_by(std::move(approach), opening_of(incision, request));
}

std::string place_in_words(const FoundIncision& incision)
{
    const std::string length = in_words(std::round(incision.length_mm)) + " mm";
    if (incision.kind == FoundIncision::Kind::sternum)
        return "sternum, sawn through, " + length;
    if (incision.kind == FoundIncision::Kind::skin)
        return "straight line about " + in_words(incision.middle) + ", " + length;
    constexpr double kBehindDeg = 75.0, kInFrontDeg = 115.0; // 90 is lateral
    return space_name(incision.space->left, incision.space->number)
        + (incision.angle_deg < kBehindDeg         ? ", towards the back, "
                : incision.angle_deg > kInFrontDeg ? ", in front, "
                                                   : ", at the side, ")
        + length;
}

} // namespace retractor::planner
