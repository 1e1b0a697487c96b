#include "planner/anatomy/deflated_lung.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr std::string_view kLung = "lung"; // material, and in the name
    /// A lung or a lobe; a cavity full of air has the material, too.
    bool is_lung(const mesh::LabelInfo& info)
    {
        return info.material == kLung && info.name.find(kLung) != std::string::npos;
    }

    constexpr std::string_view kDeflated = "_deflated"; // behind the name of the label

    Vec3 middle_of(std::span<const TriMesh* const> surfaces)
    {
        Vec3 sum = Vec3::Zero();
        Eigen::Index count = 0;
        for (const TriMesh* surface : surfaces) {
            sum += surface->vertices.colwise().sum().transpose();
            count += surface->vertices.rows();
        }
        RETRACTOR_ASSERT(count > 0);
        return sum / static_cast<double>(count);
    }

} // namespace

Vec3 hilum(std::span<const TriMesh* const> lung, const TriMesh* windpipe, const AnatomicalFrame& frame)
{
    Vec3 root;
    if (windpipe != nullptr && windpipe->vertices.rows() > 0) {
        Eigen::Index lowest = 0;
        (windpipe->vertices * frame.superior).minCoeff(&lowest);
        root = windpipe->vertices.row(lowest).transpose();
    } else {
        constexpr double kFromBack = 1.0 / 3.0;
        double back = std::numeric_limits<double>::infinity(), front = -back;
        for (const TriMesh* surface : lung) {
            const Eigen::VectorXd forwards = surface->vertices * frame.anterior;
            back = std::min(back, forwards.minCoeff());
            front = std::max(front, forwards.maxCoeff());
        }
        const Vec3 middle = middle_of(lung);
        root = middle - (middle - frame.origin).dot(frame.left) * frame.left
            + (back + kFromBack * (front - back) - middle.dot(frame.anterior)) * frame.anterior;
    }
    Vec3 nearest = root;
    double least = std::numeric_limits<double>::infinity();
    for (const TriMesh* surface : lung)
        for (Eigen::Index v = 0; v < surface->vertices.rows(); ++v) {
            const Vec3 at = surface->vertices.row(v).transpose();
            if (const double squared = (at - root).squaredNorm(); squared < least) {
                least = squared;
                nearest = at;
            }
        }
    return nearest;
}

TriMesh shrunk(TriMesh surface, const Vec3& towards, double volume_share)
{
    if (!(volume_share > 0.0) || volume_share > 1.0)
        throw InputError("a share of a volume must be above 0 and at most 1");
    const double scale = std::cbrt(volume_share);
    surface.vertices = (scale * surface.vertices).rowwise() + (1.0 - scale) * towards.transpose();
    return surface;
}

Vec3 held_away(std::span<const TriMesh* const> whole, std::span<const TriMesh> deflated, const Vec3& from,
    const Vec3& to, const AnatomicalFrame& frame)
{
    std::vector<const TriMesh*> parts;
    for (const TriMesh& part : deflated)
        parts.push_back(&part);
    const Vec3 middle = middle_of(parts), line = (to - from).normalized();
    Vec3 away = middle - from;
    away -= away.dot(line) * line;
    constexpr double kOnLineMm = 1.0; // no direction is away
    if (away.norm() < kOnLineMm)
        return Vec3::Zero();
    away.normalize();
    const auto reach = [](std::span<const TriMesh* const> surfaces, const Vec3& direction) {
        double farthest = -std::numeric_limits<double>::infinity();
        for (const TriMesh* surface : surfaces)
            farthest = std::max(farthest, (surface->vertices * direction).maxCoeff());
        return farthest;
    };
    double shift = kHeldAwayMm;
    for (const Vec3& axis : { frame.left, frame.anterior, frame.superior })
        for (const Vec3& direction : { axis, Vec3(-axis) })
            if (const double along = away.dot(direction); along > 0.0)
                shift = std::min(shift, std::max(0.0, reach(whole, direction) - reach(parts, direction)) / along);
    return shift * away;
}

std::string label_of_deflated(const std::string& name)
{
    return name.ends_with(kDeflated) ? name.substr(0, name.size() - kDeflated.size()) : name;
}

std::vector<DeflatedLung> deflated_lungs(const Approach& approach, Patient& patient, double volume_share)
{
    const mesh::LabelTable& table = patient.planned_case().label_table;
    // The lung that holds a spherical target is operated on.
    const Label inside = approach.target.is_sphere() ? mesh::label_at(*patient.labels(), approach.target.centre) : 0;
    const auto is_aside = [&](const mesh::LabelInfo& info) {
        return is_lung(info) && info.name != approach.target.label && info.id != inside
            && std::find(approach.retracted.begin(), approach.retracted.end(), info.name) != approach.retracted.end();
    };
    if (std::none_of(table.begin(), table.end(), is_aside))
        return {};
    const AnatomicalFrame frame = patient.frame();
    std::shared_ptr<const TriMesh> windpipe;
    for (const char* name : { "trachea", "windpipe", "airway" })
        if (windpipe == nullptr && mesh::find_label(table, name) != nullptr && patient.has_voxels(name))
            windpipe = patient.organ(name);
    const std::shared_ptr<const TriMesh> target = patient.target(approach.target);
    const TriMesh* const looked_at[] = { target.get() };
    RETRACTOR_ASSERT(!approach.incision.empty());
    const Vec3 incision = approach.incision[approach.incision.size() / 2];
    std::vector<DeflatedLung> lungs;
    for (const bool left : { false, true }) {
        std::vector<std::shared_ptr<const TriMesh>> kept;
        std::vector<const TriMesh*> side, whole;
        std::vector<const mesh::LabelInfo*> aside;
        for (const mesh::LabelInfo& info : table) {
            if (!is_lung(info) || info.role == mesh::Role::wall || !patient.has_voxels(info.name))
                continue;
            kept.push_back(patient.organ(info.name));
            const TriMesh* const alone[] = { kept.back().get() };
            if (alone[0]->vertices.rows() == 0 || ((middle_of(alone) - frame.origin).dot(frame.left) > 0.0) != left)
                continue;
            side.push_back(alone[0]);
            if (is_aside(info)) {
                whole.push_back(alone[0]);
                aside.push_back(&info);
            }
        }
        if (aside.empty())
            continue;
        const Vec3 towards = hilum(side, windpipe.get(), frame);
        std::vector<TriMesh> deflated;
        for (const TriMesh* lobe : whole)
            deflated.push_back(shrunk(*lobe, towards, volume_share));
        const Vec3 away = held_away(whole, deflated, incision, middle_of(looked_at), frame);
        for (std::size_t n = 0; n < aside.size(); ++n) {
            deflated[n].vertices.rowwise() += away.transpose();
            lungs.push_back({ .label = aside[n]->name,
                .name = aside[n]->name + std::string(kDeflated),
                .material = aside[n]->material,
                .surface = std::move(deflated[n]) });
        }
    }
    return lungs;
}

} // namespace retractor::planner
