#include "tests/benchmarks/framework/bench_bodies.h"

#include "datasets/io/label_table.h"
#include "mesh/base/error.h"
#include "mesh/generation/hybrid_model.h"
#include "planner/approach/approach_templates.h"
#include "planner/case/case.h"
#include "planner/wall/wall_cut.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace retractor::benchmarks {

namespace {

    constexpr double kSpacing = 4.0;
    constexpr double kBlockLength = 60.0, kBlockDepth = 12.0;
    constexpr double kSeveringLength = 110.0, kSeveringDepth = 30.0;
    constexpr double kHeadingDeg = 7.3, kTiltDeg = 10.0;
    constexpr double kHandSwing = 4.0, kHandTurnDeg = 5.0; // amplitudes of a hand, mm and degrees
    constexpr double kHandSwings = 1.3, kHandTurns = 2.0; // number of swings and turns over the whole line
    constexpr double kThoraxEdge = 3.0, kThoraxCoarse = 15.0;

    struct BoxCells {
        const char* name;
        std::array<int, 3> cells;
    };
    constexpr std::array<BoxCells, 3> kBoxes { { { "12k", { 20, 20, 5 } }, { "96k", { 40, 40, 10 } },
        { "1M", { 100, 100, 17 } } } };

    mesh::Blade box_blade(const std::array<int, 3>& cells, double length, double depth)
    {
        const double heading = kHeadingDeg * std::numbers::pi / 180.0, tilt = kTiltDeg * std::numbers::pi / 180.0;
        const Vec3 along(std::cos(heading), std::sin(heading), 0.0), across(-std::sin(heading), std::cos(heading), 0.0);
        const Vec3 centre(0.5 * cells[0] * kSpacing + 1.3, 0.5 * cells[1] * kSpacing + 0.9, cells[2] * kSpacing);
        return { .line = { centre - 0.5 * length * along, centre + 0.5 * length * along },
            .directions = { -std::cos(tilt) * Vec3::UnitZ() + std::sin(tilt) * across },
            .depth_mm = depth };
    }

} // namespace

mesh::Blade resampled(const mesh::Blade& blade, double step)
{
    std::vector<double> at { 0.0 };
    for (std::size_t i = 1; i < blade.line.size(); ++i)
        at.push_back(at.back() + (blade.line[i] - blade.line[i - 1]).norm());
    mesh::Blade out { .line = {}, .directions = {}, .depth_mm = blade.depth_mm, .above_mm = blade.above_mm };
    if (blade.directions.size() == 1)
        out.directions = blade.directions;
    const int count = std::max(1, static_cast<int>(std::lround(at.back() / step)));
    std::size_t piece = 1;
    for (int i = 0; i <= count; ++i) {
        const double s = at.back() * i / count;
        while (piece + 1 < at.size() && at[piece] < s)
            ++piece;
        const double t = (s - at[piece - 1]) / (at[piece] - at[piece - 1]);
        out.line.push_back((1.0 - t) * blade.line[piece - 1] + t * blade.line[piece]);
        if (blade.directions.size() > 1)
            out.directions.push_back((1.0 - t) * blade.directions[piece - 1] + t * blade.directions[piece]);
    }
    return out;
}

mesh::Blade drawn_by_hand(const mesh::Blade& blade)
{
    mesh::Blade hand = blade;
    const std::size_t count = blade.line.size();
    if (hand.directions.size() == 1)
        hand.directions.assign(count, Vec3(blade.directions.front()));
    const Vec3 along = (blade.line.back() - blade.line.front()).normalized();
    const Vec3 across = along.cross(hand.directions[count / 2]).normalized();
    for (std::size_t i = 0; i < count; ++i) {
        const double phase = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count - 1);
        hand.line[i] += kHandSwing * std::sin(kHandSwings * phase) * across;
        const double turn = kHandTurnDeg * std::numbers::pi / 180.0 * std::sin(kHandTurns * phase);
        hand.directions[i] = Vec3(Eigen::AngleAxisd(turn, along) * hand.directions[i]);
    }
    return hand;
}

mesh::Blade beginning(const mesh::Blade& blade, std::size_t points)
{
    mesh::Blade part = blade;
    part.line.resize(points);
    if (part.directions.size() > 1)
        part.directions.resize(points);
    return part;
}

BenchBody bench_box(const std::string& name)
{
    const auto* const box
        = std::find_if(kBoxes.begin(), kBoxes.end(), [&](const BoxCells& b) { return name == b.name; });
    if (box == kBoxes.end())
        throw InputError("there is no bench box of this name", name);
    const auto& n = box->cells;
    return { name, mesh::kuhn_box(n[0], n[1], n[2], kSpacing),
        resampled(box_blade(n, kBlockLength, kBlockDepth), kFreehandStep), {}, {} };
}

BenchBody bench_box_severed()
{
    BenchBody body = bench_box("12k");
    body.name = "severed";
    body.blade = box_blade(kBoxes[0].cells, kSeveringLength, kSeveringDepth);
    return body;
}

BenchWall bench_wall(const datasets::Phantom& phantom, const planner::Approach& approach, const Job& job)
{
    const mesh::MeshSizing sizing = planner::mesh_sizing_of(approach, phantom.labels.table);
    mesh::HybridModel model = mesh::build_hybrid_model(phantom.labels, sizing, job);
    if (model.status != mesh::MeshStatus::done)
        throw SolverError("the thorax of the bench was not meshed: " + model.message);
    planner::Case planned_case;
    planned_case.label_table = phantom.labels.table;
    fem::Supports supports = planner::supports_of(model.wall, phantom.labels, planned_case, sizing);
    BenchWall wall { std::move(model.wall), std::move(supports), {} };
    for (const mesh::LabelInfo& info : phantom.labels.table) {
        if (wall.materials.size() <= info.id)
            wall.materials.resize(static_cast<std::size_t>(info.id) + 1);
        if (info.role == mesh::Role::wall)
            wall.materials[info.id] = fem::find_material(planned_case.materials, info.material);
    }
    return wall;
}

BenchBody bench_thorax(const Job& job)
{
    const datasets::Phantom phantom = datasets::make_thorax_phantom({ .noise_hu = 0.0 }, job);
    planner::ApproachRequest request;
    request.template_name = "median";
    request.target.label = "aneurysm";
    request.sizing.corridor_edge_mm = kThoraxEdge;
    request.sizing.coarse_edge_mm = kThoraxCoarse;
    const planner::Approach approach = planner::approach_from_template(phantom.labels, request);
    BenchWall wall = bench_wall(phantom, approach, job);
    BenchBody body { "thorax", std::move(wall.mesh), resampled(planner::blade_of(approach), kFreehandStep), {}, {},
        std::move(wall.supports), std::move(wall.materials) };
    for (const mesh::LabelInfo& info : phantom.labels.table) {
        if (info.name == "skin")
            body.skin.push_back(info.id);
        if (std::find(approach.uncut_labels.begin(), approach.uncut_labels.end(), info.name)
            != approach.uncut_labels.end())
            body.uncut_labels.push_back(info.id);
    }
    return body;
}

} // namespace retractor::benchmarks
