#include "planner/case/patient.h"

#include "datasets/io/volume_io.h"
#include "mesh/base/error.h"
#include "mesh/image/skeleton.h"
#include "mesh/surface/label_surface.h"
#include "planner/case/target_site.h"
#include "planner/wall/image_end.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace retractor::planner {

namespace {

    /// The body is only looked at, so its surface may be smooth enough to hide the voxels.
    constexpr double kBodySmoothingMm = 2.5;

    std::size_t bytes_of(const TriMesh& surface)
    {
        return static_cast<std::size_t>(surface.vertices.size()) * sizeof(double)
            + surface.triangles.size() * sizeof(surface.triangles[0]);
    }

} // namespace

Patient::Patient(Case planned_case, Job job)
    : case_(std::move(planned_case))
    , job_(std::move(job))
{
}

std::shared_ptr<const mesh::Volume> Patient::ct()
{
    const std::lock_guard lock(mutex_);
    if (!case_.ct)
        throw InputError("the case has no CT", "/ct");
    if (!ct_)
        ct_ = std::make_shared<const mesh::Volume>(datasets::read_volume(case_.ct_path(), job_));
    return ct_;
}

std::shared_ptr<const mesh::LabelVolume> Patient::labels()
{
    const std::lock_guard lock(mutex_);
    if (!labels_) {
        mesh::LabelVolume labels = datasets::read_label_volume(case_.labels_path(), job_);
        labels.table = case_.label_table;
        labels_ = std::make_shared<const mesh::LabelVolume>(std::move(labels));
    }
    return labels_;
}

std::shared_ptr<const Anatomy> Patient::anatomy()
{
    const std::lock_guard lock(mutex_);
    if (!anatomy_)
        anatomy_ = std::make_shared<const Anatomy>(find_anatomy(*labels()));
    return anatomy_;
}

std::shared_ptr<const std::vector<BoneStiffness>> Patient::bone_stiffness()
{
    const std::lock_guard lock(mutex_);
    if (!bone_stiffness_) {
        const auto all_labels = labels();
        std::shared_ptr<const mesh::Volume> image;
        std::string without = "the case has no CT";
        const bool has_bones = std::any_of(case_.label_table.begin(), case_.label_table.end(),
            [](const mesh::LabelInfo& info) { return mesh::is_wall(info) && mesh::is_skeleton(info); });
        if (case_.ct && has_bones) {
            try {
                image = ct();
            } catch (const Error& error) { // a plan needs no CT, so that a CT that is gone stops none
                without = "the CT cannot be read (" + std::string(error.what()) + ")";
            }
        }
        const Stopwatch watch;
        auto found = std::make_shared<const std::vector<BoneStiffness>>(
            find_bone_stiffness(*all_labels, image.get(), case_.materials, without));
        record_part(job_, "stiffness of ribs", watch, found->size() * sizeof(BoneStiffness));
        bone_stiffness_ = std::move(found);
    }
    return bone_stiffness_;
}

AnatomicalFrame Patient::frame()
{
    if (mesh::find_label(case_.label_table, "sternum") != nullptr && has_voxels("sternum"))
        return anatomy()->frame;
    return { .origin = Vec3::Zero(), .superior = Vec3::UnitZ(), .anterior = -Vec3::UnitY(), .left = Vec3::UnitX() };
}

bool Patient::has_voxels(std::string_view name)
{
    const std::lock_guard lock(mutex_);
    const Label wanted = mesh::label_named(case_.label_table, name).id;
    if (label_occurs_.empty())
        label_occurs_ = mesh::flagged_labels(labels()->voxels);
    return label_occurs_[wanted] != 0;
}

std::shared_ptr<const TriMesh> Patient::organ(std::string_view name)
{
    const std::lock_guard lock(mutex_);
    if (const auto found = organs_.find(name); found != organs_.end())
        return found->second;
    const std::array<Label, 1> which { mesh::label_named(case_.label_table, name).id };
    const Stopwatch watch;
    auto surface = std::make_shared<const TriMesh>(mesh::label_surface(*labels(), which));
    if (surface->triangles.empty())
        throw InputError("the label has no voxel", std::string(name));
    record_part(job_, "surface " + std::string(name), watch, bytes_of(*surface));
    organs_.emplace(name, surface);
    return surface;
}

std::shared_ptr<const TriMesh> Patient::body()
{
    const std::lock_guard lock(mutex_);
    if (!body_) {
        const Stopwatch watch;
        std::vector<Label> wall;
        for (const mesh::LabelInfo& info : case_.label_table)
            if (info.role == mesh::Role::wall)
                wall.push_back(info.id);
        body_ = std::make_shared<const TriMesh>(mesh::viewing_surface(*labels(), wall, kBodySmoothingMm));
        if (body_->triangles.empty())
            throw InputError("no voxel has a label of role wall", case_.labels.path.string());
        record_part(job_, "surface body", watch, bytes_of(*body_));
    }
    return body_;
}

std::shared_ptr<const TriMesh> Patient::image_end()
{
    const std::lock_guard lock(mutex_);
    if (!image_end_) {
        const Stopwatch watch;
        image_end_ = std::make_shared<const TriMesh>(image_end_faces(*labels()));
        record_part(job_, "surface image end", watch, bytes_of(*image_end_));
    }
    return image_end_;
}

std::shared_ptr<const TriMesh> Patient::target(const TargetSpec& target)
{
    if (target.is_sphere())
        return std::make_shared<const TriMesh>(sphere_surface(target.centre, target.radius_mm));
    if (target.is_site())
        return std::make_shared<const TriMesh>(site_surface(*organ(target.label), target));
    return organ(target.label);
}

std::vector<fem::Material> materials_as_solved(Patient& patient, ElementKind element)
{
    std::vector<fem::Material> materials = materials_as_solved(patient.planned_case(), element);
    apply_bone_stiffness(*patient.bone_stiffness(), materials);
    scale_materials(patient.stiffness_factors(), materials);
    return materials;
}

std::vector<fem::Material> materials_as_solved(Patient& patient)
{
    return materials_as_solved(patient, patient.planned_case().solution.element);
}

TriMesh sphere_surface(const Vec3& centre, double radius_mm)
{
    // Four subdivisions of the icosahedron: chords deviate by 0.1 % of the radius.
    constexpr int kSubdivisions = 4;
    const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
    std::vector<Vec3> points { { -1, golden, 0 }, { 1, golden, 0 }, { -1, -golden, 0 }, { 1, -golden, 0 },
        { 0, -1, golden }, { 0, 1, golden }, { 0, -1, -golden }, { 0, 1, -golden }, { golden, 0, -1 }, { golden, 0, 1 },
        { -golden, 0, -1 }, { -golden, 0, 1 } };
    std::vector<std::array<VertexId, 3>> triangles { { 0, 11, 5 }, { 0, 5, 1 }, { 0, 1, 7 }, { 0, 7, 10 },
        { 0, 10, 11 }, { 1, 5, 9 }, { 5, 11, 4 }, { 11, 10, 2 }, { 10, 7, 6 }, { 7, 1, 8 }, { 3, 9, 4 }, { 3, 4, 2 },
        { 3, 2, 6 }, { 3, 6, 8 }, { 3, 8, 9 }, { 4, 9, 5 }, { 2, 4, 11 }, { 6, 2, 10 }, { 8, 6, 7 }, { 9, 8, 1 } };
    for (int level = 0; level < kSubdivisions; ++level) {
        std::map<std::pair<VertexId, VertexId>, VertexId> middles;
        const auto middle = [&](VertexId a, VertexId b) {
            const std::pair<VertexId, VertexId> key { std::min(a, b), std::max(a, b) };
            const auto [it, inserted] = middles.try_emplace(key, static_cast<VertexId>(points.size()));
            if (inserted)
                points.push_back((points[static_cast<std::size_t>(a)].normalized()
                                     + points[static_cast<std::size_t>(b)].normalized())
                    / 2.0);
            return it->second;
        };
        std::vector<std::array<VertexId, 3>> finer;
        for (const auto& [a, b, c] : triangles) {
            const VertexId ab = middle(a, b);
            const VertexId bc = middle(b, c);
            const VertexId ca = middle(c, a);
            finer.insert(finer.end(), { { a, ab, ca }, { ab, b, bc }, { ca, bc, c }, { ab, bc, ca } });
        }
        triangles = std::move(finer);
    }
    TriMesh sphere;
    sphere.triangles = std::move(triangles);
    sphere.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i)
        sphere.vertices.row(static_cast<Eigen::Index>(i)) = (centre + radius_mm * points[i].normalized()).transpose();
    return sphere;
}

bool stays_in_place(const mesh::LabelInfo& label, const Approach& approach, Patient& patient)
{
    return label.role != mesh::Role::wall
        && std::find(approach.retracted.begin(), approach.retracted.end(), label.name) == approach.retracted.end()
        && patient.has_voxels(label.name);
}

} // namespace retractor::planner
