#include "planner/ports/port_scene.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"
#include "planner/measures/sight/surgeon_eye.h"
#include "planner/plan/wound_view.h"
#include "planner/search/aperture_score.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace retractor::planner {

namespace {

    constexpr double kDegree = std::numbers::pi / 180.0;
    constexpr unsigned kEverything = kTargetMask | kOrganMask | kWallMask;

    Vec3 across(const Vec3& line)
    {
        const Vec3 other = std::abs(line.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY();
        return line.cross(other).normalized();
    }

    double angle(const Vec3& a, const Vec3& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }

    std::vector<Occluder> blockers_of(
        Patient& patient, const TargetSpec& target, bool left, const std::vector<std::string>& aside, bool whole_wall)
    {
        const mesh::LabelTable& table = patient.planned_case().label_table;
        Approach approach;
        approach.target = target;
        approach.retracted
            = organs_aside(table, target, left ? ApertureKind::left_space : ApertureKind::right_space, aside);
        std::vector<Occluder> blockers = organ_occluders(approach, patient, { .lung_share = 0.0 });
        if (whole_wall) {
            blockers.push_back(
                { .name = "wall", .surface = *patient.body(), .labels = {}, .material = {}, .wall = true });
            return blockers;
        }
        for (const mesh::LabelInfo& info : table)
            if (mesh::is_wall(info) && mesh::is_skeleton(info) && patient.has_voxels(info.name))
                blockers.push_back({ .name = info.name,
                    .surface = *patient.organ(info.name),
                    .labels = {},
                    .material = info.material,
                    .wall = true });
        return blockers;
    }

} // namespace

void check_optics(const Optics& optics)
{
    if (!(optics.tilt_deg >= 0.0 && optics.tilt_deg <= 60.0))
        throw InputError("the optics' angle must be between 0 and 60 degrees, got " + in_words(optics.tilt_deg));
    if (!(optics.field_deg > 0.0 && optics.field_deg <= 120.0))
        throw InputError("the view cone must be above 0 and at most 120 degrees, got " + in_words(optics.field_deg));
}

PortScene::PortScene(Patient& patient, const TargetSpec& target, bool left, const std::vector<std::string>& aside,
    int samples, const Job& job)
    : PortScene(*patient.target(target), blockers_of(patient, target, left, aside, true),
        blockers_of(patient, target, left, aside, false), samples, job)
{
}

PortScene::PortScene(const TriMesh& target, std::vector<Occluder> view_blockers, std::vector<Occluder> shaft_blockers,
    int samples, const Job& job)
    : view_(std::make_unique<RayScene>(target, std::move(view_blockers), job))
    , shafts_(std::make_unique<RayScene>(target, std::move(shaft_blockers), job))
    , samples_(surface_samples(target, samples))
{
    for (const SurfaceSample& sample : samples_)
        middle_ += sample.position / static_cast<double>(samples_.size());
}

bool PortScene::shaft_fits(const Vec3& tip, const Vec3& skin, double diameter_mm, double taper_mm) const
{
    constexpr int kRays = 6; // on the shaft's surface
    const double length = (skin - tip).norm();
    const Vec3 outward = (skin - tip) / length;
    if (!shafts_->clear(tip, outward, kTouchingMm, length, kEverything))
        return false;
    const Vec3 u = across(outward), v = outward.cross(u);
    for (int i = 0; i < kRays; ++i) {
        const double turn = 2.0 * std::numbers::pi * i / kRays;
        const Vec3 from = tip + 0.5 * diameter_mm * (std::cos(turn) * u + std::sin(turn) * v);
        if (!shafts_->clear(from, outward, taper_mm, length, kEverything))
            return false;
    }
    return true;
}

ScopeView PortScene::look(const Vec3& skin, const Vec3& tip, const Optics& optics) const
{
    const Vec3 shaft = (tip - skin).normalized(), to_middle = (middle_ - tip).normalized();
    ScopeView view { .tip = tip, .insertion_mm = (tip - skin).norm(), .to_target_mm = (middle_ - tip).norm() };
    view.sees.assign(samples_.size(), false);
    // The surgeon turns the scope until its view comes nearest to the target.
    const Vec3 about = shaft.cross(to_middle);
    view.view = about.norm() > 1e-9 ? Vec3(Eigen::AngleAxisd(optics.tilt_deg * kDegree, about.normalized()) * shaft)
                                    : Vec3(Eigen::AngleAxisd(optics.tilt_deg * kDegree, across(shaft)) * shaft);
    const double widest = std::cos(0.5 * optics.field_deg * kDegree),
                 least_cosine = std::cos(kLargestIncidenceDeg * kDegree);
    for (std::size_t s = 0; s < samples_.size(); ++s) {
        const SurfaceSample& sample = samples_[s];
        const Vec3 line = sample.position - tip;
        const double distance = line.norm();
        const Vec3 direction = line / distance;
        if (std::abs(view_->normal(sample).dot(direction)) < least_cosine
            || !view_->clear(tip, direction, 0.0, distance - kSampleToleranceMm, kTargetMask))
            continue;
        ++view.bound;
        view.sees[s] = direction.dot(view.view) >= widest
            && view_->clear(tip, direction, 0.0, distance - kTouchingMm, kOrganMask | kWallMask);
        view.seen += view.sees[s] ? 1 : 0;
    }
    return view;
}

ScopeView PortScene::best_scope(const Vec3& skin, double wall_mm, const Optics& optics, const PortSizes& sizes) const
{
    constexpr std::array kFromTargetMm { 50.0, 70.0, 95.0, 130.0 };
    constexpr double kInsideMm = 15.0; // the lens has left the trocar
    constexpr int kRings = 3, kTurns = 8;
    constexpr double kWidest = 45.0 * kDegree; // between the line to the port and that to the tip, at the target
    const Vec3 home = (skin - middle_).normalized();
    const Vec3 u = across(home), v = home.cross(u);
    ScopeView best;
    for (const double distance : kFromTargetMm)
        for (int ring = 0; ring <= kRings; ++ring)
            for (int turn = 0; turn < (ring == 0 ? 1 : kTurns); ++turn) {
                const double off = kWidest * ring / kRings, round = 2.0 * std::numbers::pi * turn / kTurns;
                const Vec3 direction
                    = std::cos(off) * home + std::sin(off) * (std::cos(round) * u + std::sin(round) * v);
                const Vec3 tip = middle_ + distance * direction;
                const double insertion = (tip - skin).norm();
                if (insertion < wall_mm + kInsideMm || insertion > sizes.longest_mm)
                    continue;
                // A view that cannot come to the target is not tried.
                const double lacks = std::abs(
                    angle((tip - skin).normalized(), (middle_ - tip).normalized()) - optics.tilt_deg * kDegree);
                if (lacks > 0.5 * optics.field_deg * kDegree || !shaft_fits(tip, skin, sizes.scope_mm, 0.0))
                    continue;
                const ScopeView view = look(skin, tip, optics);
                if (view.seen > best.seen || best.insertion_mm == 0.0)
                    best = view;
            }
    return best;
}

std::vector<bool> PortScene::reached(const Vec3& skin, const PortSizes& sizes) const
{
    constexpr double kTaperMm = 10.0;
    std::vector<bool> reached(samples_.size(), false);
    for (std::size_t s = 0; s < samples_.size(); ++s)
        reached[s] = (skin - samples_[s].position).norm() <= sizes.longest_mm
            && shaft_fits(samples_[s].position, skin, sizes.shaft_mm, kTaperMm);
    return reached;
}

double distance_of_pieces(const std::pair<Vec3, Vec3>& one, const std::pair<Vec3, Vec3>& other)
{
    const Vec3 p = one.second - one.first, q = other.second - other.first, r = other.first - one.first;
    const double a = p.squaredNorm(), b = p.dot(q), c = q.squaredNorm(), d = p.dot(r), e = q.dot(r);
    const double determinant = a * c - b * b;
    double s = determinant > 1e-12 * a * c ? std::clamp((d * c - b * e) / determinant, 0.0, 1.0) : 0.0;
    double t = c > 0.0 ? std::clamp((b * s - e) / c, 0.0, 1.0) : 0.0;
    s = a > 0.0 ? std::clamp((b * t + d) / a, 0.0, 1.0) : 0.0; // for the t within the piece
    t = c > 0.0 ? std::clamp((b * s - e) / c, 0.0, 1.0) : 0.0;
    return (one.first + s * p - other.first - t * q).norm();
}

} // namespace retractor::planner
