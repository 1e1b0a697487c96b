#include "planner/approach/retractors.h"

#include "datasets/io/strict_json.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/hooks.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>
#include <utility>

namespace retractor::planner {

namespace {

    using Json = nlohmann::ordered_json;

    const std::array<RetractorKind, 3>& table()
    {
        // Makers give many sizes under one name. These are middle sizes for adults. Blades of a closed spreader lie
        // against each other over their whole depth, so their play is small: a blade's slide has a gap of about 3
        // degrees, and an arm of steel, 100 mm long and 10 by 5 mm thick, twists by 2 under 200 N at 35 mm below it.
        // The usual blades of a sternal spreader are shallow and twist their arms less. All come with deeper blades for
        // thick walls: a blade that ends in the fat above the bone opens the skin only.
        static const std::array<RetractorKind, 3> kinds { {
            { .kind = "finochietto",
                .meaning = "two broad blades on a rack, each turns about its arm",
                .blade_width_mm = 48.0,
                .blade_depth_mm = 65.0,
                .deepest_blade_mm = 100.0,
                .play_deg = 5.0,
                .greatest_opening_mm = 200.0,
                .source = "ours" },
            { .kind = "sternal",
                .meaning = "two long blades, almost fixed to their arms",
                .blade_width_mm = 90.0,
                .blade_depth_mm = 35.0,
                .deepest_blade_mm = 80.0,
                .play_deg = 3.0,
                .greatest_opening_mm = 200.0,
                .source = "ours" },
            { .kind = "midcab",
                .meaning = "two small blades, for small incisions and the mitral valve",
                .blade_width_mm = 30.0,
                .blade_depth_mm = 40.0,
                .deepest_blade_mm = 80.0,
                .play_deg = 5.0,
                .greatest_opening_mm = 90.0,
                .source = "ours" },
        } };
        return kinds;
    }

    double positive_number(const Json& row, const char* key, double largest, const std::string& where)
    {
        const std::string at = where + "/" + key;
        if (!row.contains(key))
            throw InputError(std::string("the key \"") + key + "\" is missing", at);
        if (!row[key].is_number())
            throw InputError("must be a number", at);
        const double value = row[key].get<double>();
        if (!(value >= 0.0 && value <= largest))
            throw InputError("must be between 0 and " + in_words(largest) + ", got " + std::to_string(value), at);
        return value;
    }

    std::string text_of(const Json& row, const char* key, const std::string& where)
    {
        if (!row.contains(key) || !row[key].is_string() || row[key].get<std::string>().empty())
            throw InputError("must be a text that is not empty", where + "/" + key);
        return row[key].get<std::string>();
    }

    RetractorKind row_of(const Json& row, const std::string& where)
    {
        constexpr double kLargestMm = 300.0; // larger than any instrument for one patient
        constexpr double kMostPlay = 90.0;
        if (!row.is_object())
            throw InputError("must be an object", where);
        RetractorKind kind { .kind = text_of(row, "kind", where),
            .meaning = text_of(row, "meaning", where),
            .blade_width_mm = positive_number(row, "blade_width_mm", kLargestMm, where),
            .blade_depth_mm = positive_number(row, "blade_depth_mm", kLargestMm, where),
            .deepest_blade_mm = positive_number(
                row, row.contains("deepest_blade_mm") ? "deepest_blade_mm" : "blade_depth_mm", kLargestMm, where),
            .play_deg = positive_number(row, "play_deg", kMostPlay, where),
            .greatest_opening_mm = positive_number(row, "greatest_opening_mm", kLargestMm, where),
            .source = text_of(row, "source", where) };
        constexpr std::size_t kKeys = 7;
        if (row.size() != kKeys + (row.contains("deepest_blade_mm") ? 1 : 0))
            throw InputError("has a key that is not known: a row has kind, meaning, blade_width_mm, blade_depth_mm, "
                             "deepest_blade_mm, play_deg, greatest_opening_mm and source",
                where);
        if (kind.deepest_blade_mm < kind.blade_depth_mm)
            throw InputError("must not be less than blade_depth_mm", where + "/deepest_blade_mm");
        return kind;
    }

} // namespace

std::span<const RetractorKind> built_in_retractors() { return table(); }

std::vector<RetractorKind> read_retractors(const std::filesystem::path& file)
{
    std::ifstream in(file);
    std::ostringstream text;
    if (!in || !(text << in.rdbuf()))
        throw IoError("cannot be read", file.string());
    const Json document = datasets::parse_strictly(text.str(), file.string());
    if (!document.is_object() || document.size() != 1 || !document.contains("retractors")
        || !document["retractors"].is_array() || document["retractors"].empty())
        throw InputError("must be {\"retractors\": [...]} with at least one row", file.string());
    std::vector<RetractorKind> kinds;
    for (std::size_t n = 0; n < document["retractors"].size(); ++n) {
        const std::string where = file.string() + ": /retractors/" + std::to_string(n);
        RetractorKind kind = row_of(document["retractors"][n], where);
        if (std::ranges::find(kinds, kind.kind, &RetractorKind::kind) != kinds.end())
            throw InputError("two retractors are named \"" + kind.kind + "\"", where + "/kind");
        kinds.push_back(std::move(kind));
    }
    return kinds;
}

const RetractorKind& find_retractor(std::span<const RetractorKind> kinds, std::string_view kind)
{
    const auto found = std::ranges::find(kinds, kind, &RetractorKind::kind);
    if (found != kinds.end())
        return *found;
    std::vector<std::string> known;
    for (const RetractorKind& row : kinds)
        known.push_back(row.kind);
    throw InputError("unknown retractor \"" + std::string(kind) + "\": the table has " + joined(known), "retractor",
        { "retractor" });
}

namespace {

    /// The usual blades of the kind, or deeper ones, as deep as the wall asks and the kind has them.
    double blade_depth_for(const Approach& approach, const RetractorKind& kind, double along_mm)
    {
        return std::max(kind.blade_depth_mm,
            std::min(depth_through_wall(approach, along_mm, kind.blade_width_mm), kind.deepest_blade_mm));
    }

} // namespace

RetractorSpec make_retractor(const Approach& approach, const RetractorKind& kind, const RetractorDrive& drive)
{
    const double along = 0.5 * incision_length(approach);
    return { .kind = kind.kind,
        .opening_mm = drive.opening_mm,
        .force_N = drive.force_N,
        .along_mm = along,
        .blade_width_mm = kind.blade_width_mm,
        .blade_depth_mm = blade_depth_for(approach, kind, along),
        .play_deg = kind.play_deg,
        .greatest_opening_mm = kind.greatest_opening_mm };
}

void deepen_blades(Approach& approach)
{
    RETRACTOR_ASSERT(approach.retractor);
    RetractorSpec& retractor = *approach.retractor;
    const auto kind = std::ranges::find(table(), retractor.kind, &RetractorKind::kind);
    if (kind != table().end())
        retractor.blade_depth_mm
            = std::max(retractor.blade_depth_mm, blade_depth_for(approach, *kind, retractor.along_mm));
}

void set_retractor(
    Case& planned_case, std::string_view approach_name, const RetractorKind& kind, const RetractorDrive& drive)
{
    Approach& approach = find_approach(planned_case, approach_name);
    Approach with = approach;
    with.hooks.clear();
    with.retractor = make_retractor(approach, kind, drive);
    check_approach(with);
    static_cast<void>(blades_of(with)); // refuses a wall that is too thin
    approach = std::move(with);
}

Approach with_retractor_at(Approach approach, RetractorSpec cranked, const Vec3& at)
{
    constexpr double kFarthestMm = 30.0;
    const double length = incision_length(approach);
    double before = 0.0, least = std::numeric_limits<double>::infinity(), along = 0.0;
    for (std::size_t n = 0; n + 1 < approach.incision.size(); ++n) {
        const Vec3 piece = approach.incision[n + 1] - approach.incision[n];
        const double share = std::clamp((at - approach.incision[n]).dot(piece) / piece.squaredNorm(), 0.0, 1.0);
        if (const double distance = (approach.incision[n] + share * piece - at).norm(); distance < least) {
            least = distance;
            along = before + share * piece.norm();
        }
        before += piece.norm();
    }
    if (!(least <= kFarthestMm))
        throw InputError(
            "the retractor lies " + in_words(least) + " mm from the incision of the approach", "retractor");
    const double half = std::min(0.5 * cranked.blade_width_mm, 0.5 * length); // blades end where the wound ends
    cranked.along_mm = std::clamp(along, half, length - half);
    approach.hooks.clear();
    approach.retractor = std::move(cranked);
    deepen_blades(approach);
    check_approach(approach);
    static_cast<void>(blades_of(approach)); // refuses a wall that is too thin
    return approach;
}

std::vector<HookSpec> blades_of(const Approach& approach)
{
    RETRACTOR_ASSERT(approach.retractor);
    const RetractorSpec& retractor = *approach.retractor;
    std::vector<HookSpec> blades
        = make_blades(approach, retractor.along_mm, retractor.blade_width_mm, retractor.blade_depth_mm);
    for (HookSpec& blade : blades) {
        blade.opening_mm = 0.5 * retractor.opening_mm;
        blade.hold = retractor.hold;
    }
    return blades;
}

fem::BladeFrame blade_frame_of(const Approach& approach)
{
    RETRACTOR_ASSERT(approach.retractor && approach.hooks.size() == 2);
    fem::BladeFrame frame;
    for (std::size_t k = 0; k < frame.size(); ++k) {
        const HookSpec& blade = approach.hooks[k];
        const PatchPlace place = patch_place(approach, blade);
        frame[k] = { .pivot = place.centre - blade.depth_mm * place.depth,
            .arm = place.along,
            .outward = blade.direction,
            .play = approach.retractor->play_deg * std::numbers::pi / 180.0 };
    }
    return frame;
}

std::string retractor_text(const RetractorSpec& retractor)
{
    return instrument_name(retractor.kind) + ", "
        + (retractor.force_N ? in_words(*retractor.force_N, 1) + " N" : in_words(retractor.opening_mm, 1) + " mm");
}

} // namespace retractor::planner
