#include "ui/report_view/field_view.h"

#include "mesh/base/base64.h"
#include "mesh/base/spatial_hash.h"
#include "mesh/base/text_format.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/plan_scene/vessel_surfaces.h"
#include "ui/scene/vtk/simplify_surface.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

namespace retractor::ui {

namespace {

    using Json = nlohmann::ordered_json;

    struct Layer {
        const char* key;
        const char* name;
    };
    constexpr std::array<Layer, 7> kLayers { { { "skin", "skin" }, { "fat", "fat" }, { "muscle", "muscle" },
        { "bone", "bone and cartilage" }, { "organs", "organs" }, { "target", "target" }, { "steel", "retractor" } } };

    /// The layer of a label of the wall, by its material.
    std::string layer_of(const mesh::LabelInfo& info)
    {
        if (info.material == "skin" || info.material == "fat")
            return info.material;
        return info.material == "bone" || info.material == "cartilage" ? "bone" : "muscle";
    }

    /// A part of a surface with one colour.
    struct Part {
        std::string layer;
        Color color;
        double opacity = 1.0;
        TriMesh opened;
        Points rest; ///< of the same vertices; empty: the part does not move
        bool meshed = false; ///< a part of the tetrahedra's boundary
        std::vector<std::uint8_t> seen {}; ///< per vertex of the target: eyes that see it, over the most, times 255
    };

    /// The triangles of a mesh that are in a list, with their own vertices.
    TriMesh taken(
        const TriMesh& mesh, const std::vector<std::size_t>& triangles, const Points& rest, Points& taken_rest)
    {
        std::vector<VertexId> id(static_cast<std::size_t>(mesh.vertices.rows()), -1), used;
        TriMesh part;
        for (const std::size_t t : triangles) {
            auto triangle = mesh.triangles[t];
            for (VertexId& v : triangle) {
                VertexId& own = id[static_cast<std::size_t>(v)];
                if (own < 0) {
                    own = static_cast<VertexId>(used.size());
                    used.push_back(v);
                }
                v = own;
            }
            part.triangles.push_back(triangle);
        }
        part.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
        taken_rest.resize(rest.rows() > 0 ? part.vertices.rows() : 0, 3);
        for (std::size_t n = 0; n < used.size(); ++n) {
            part.vertices.row(static_cast<Eigen::Index>(n)) = mesh.vertices.row(used[n]);
            if (rest.rows() > 0)
                taken_rest.row(static_cast<Eigen::Index>(n)) = rest.row(used[n]);
        }
        return part;
    }

    /// Divides a surface with several tissues into parts of one layer and colour.
    void add_tissues(
        std::vector<Part>& parts, const SurfaceItem& item, const mesh::LabelTable& table, const Points& rest)
    {
        const auto key_of = [&](Label label) {
            const mesh::LabelInfo* info = mesh::find_label(table, label);
            const Color color = item.look_of_label.at(label).color;
            return std::tuple(info != nullptr ? layer_of(*info) : std::string("muscle"), color.r, color.g, color.b);
        };
        std::map<std::tuple<std::string, double, double, double>, std::vector<std::size_t>> groups;
        for (std::size_t t = 0; t < item.mesh->triangles.size(); ++t)
            groups[key_of(item.mesh->labels[t])].push_back(t);
        for (const auto& [key, triangles] : groups) {
            const auto& [layer, r, g, b] = key;
            Part part { .layer = layer, .color = { r, g, b }, .opacity = item.opacity, .opened = {}, .rest = {} };
            part.meshed = item.name == kWallName;
            part.opened = taken(*item.mesh, triangles, rest, part.rest);
            parts.push_back(std::move(part));
        }
    }

    std::vector<Part> parts_of(planner::Patient& patient, const planner::PlannedField& field, const Scene& scene)
    {
        const mesh::LabelTable& table = patient.planned_case().label_table;
        std::vector<Part> parts;
        for (const SurfaceItem& item : scene.surfaces) {
            if (item.name == kImageEndName)
                continue;
            if (item.name == kWallName) {
                add_tissues(parts, item, table, drawn_wall(patient, field, {}).vertices);
            } else if (item.name == kBeyondName) {
                const TriMesh rest = remaining_wall_at_rest(patient, field);
                const bool same = rest.vertices.rows() == item.mesh->vertices.rows();
                add_tissues(parts, item, table, same ? rest.vertices : Points());
            } else if (!item.look_of_label.empty()) {
                add_tissues(parts, item, table, {});
            } else {
                const bool steel = item.look.finish == Finish::metal;
                parts.push_back({ .layer = item.target ? "target"
                        : steel                        ? "steel"
                                                       : "organs",
                    .color = item.look.color,
                    .opacity = item.opacity,
                    .opened = *item.mesh,
                    .rest = {} });
            }
        }
        return parts;
    }

    /// Simplifies a part. A vertex that is new moves as the nearest of the old ones did.
    void simplify(Part& part, double share)
    {
        constexpr double kCellMm = 4.0, kReachMm = 16.0;
        SpatialHash<Eigen::Index> vertices(kCellMm);
        for (Eigen::Index v = 0; v < part.rest.rows(); ++v)
            vertices.add(part.opened.vertices.row(v).transpose(), v);
        const TriMesh full = std::exchange(part.opened, simplified(part.opened, share));
        if (part.rest.rows() == 0)
            return;
        const Points full_rest = std::exchange(part.rest, part.opened.vertices);
        for (Eigen::Index v = 0; v < part.rest.rows(); ++v) {
            const Vec3 at = part.opened.vertices.row(v).transpose();
            double nearest = std::numeric_limits<double>::infinity();
            for (double reach = kCellMm; nearest > reach && reach <= kReachMm; reach *= 2.0)
                vertices.visit_near(at, reach, [&](Eigen::Index old) {
                    const double distance = (full.vertices.row(old).transpose() - at).norm();
                    if (distance < nearest) {
                        nearest = distance;
                        part.rest.row(v) = at.transpose() + full_rest.row(old) - full.vertices.row(old);
                    }
                    return true;
                });
        }
    }

    /// Simplifies what lies beyond the meshed wall, down to kReportTriangles together.
    void simplify(std::vector<Part>& parts)
    {
        constexpr std::size_t kSmall = 2000; // triangles; a blade or a site loses its shape before it saves anything
        const auto is_simplified
            = [](const Part& part) { return !part.meshed && part.opened.triangles.size() > kSmall; };
        std::size_t all = 0;
        for (const Part& part : parts)
            all += is_simplified(part) ? part.opened.triangles.size() : 0;
        if (all <= kReportTriangles)
            return;
        const double share = static_cast<double>(kReportTriangles) / static_cast<double>(all);
        for (Part& part : parts)
            if (is_simplified(part))
                simplify(part, share);
    }

    // ---- how much is seen -----------------------------------------------------------------------------------------

    /// The largest share of the eyes that see one place of the target; 0: nothing is seen, or it was not measured.
    double largest_share_of_eyes(const planner::Exposure& exposure)
    {
        return exposure.sample_seen.empty() ? 0.0
                                            : static_cast<double>(*std::ranges::max_element(exposure.sample_seen));
    }

    /// Gives every vertex of the target the number of eyes of the nearest sample.
    void colour_target(Part& target, const planner::Exposure& exposure)
    {
        constexpr double kCellMm = 5.0, kFarMm = 80.0; // samples of a large target lie some mm apart
        const double most = largest_share_of_eyes(exposure);
        if (!(most > 0.0))
            return;
        SpatialHash<std::size_t> samples(kCellMm);
        for (std::size_t n = 0; n < exposure.sample_points.size(); ++n)
            samples.add(exposure.sample_points[n].position, n);
        for (Eigen::Index v = 0; v < target.opened.vertices.rows(); ++v) {
            const Vec3 at = target.opened.vertices.row(v).transpose();
            double nearest = std::numeric_limits<double>::infinity(), share = 0.0;
            for (double reach = kCellMm; nearest > reach && reach < kFarMm; reach *= 2.0)
                samples.visit_near(at, reach, [&](std::size_t n) {
                    const double distance = (exposure.sample_points[n].position - at).norm();
                    if (distance < nearest) {
                        nearest = distance;
                        share = static_cast<double>(exposure.sample_seen[n]);
                    }
                    return true;
                });
            target.seen.push_back(static_cast<std::uint8_t>(std::lround(255.0 * share / most)));
        }
    }

    /// The eyes with the shares that they see; null where nothing is seen.
    Json eyes_document(const planner::Exposure& exposure)
    {
        const double most = largest_share_of_eyes(exposure);
        if (!(most > 0.0))
            return {};
        Json places = Json::array();
        double largest = 0.0;
        for (const planner::EyeView& view : exposure.eyes) {
            places.push_back({ view.eye.x(), view.eye.y(), view.eye.z(), view.visible_fraction });
            largest = std::max(largest, view.visible_fraction);
        }
        return { { "places", places }, { "largest_share", largest },
            { "most_that_see", std::lround(most * static_cast<double>(exposure.eyes.size())) } };
    }

    // ---- numbers as text ------------------------------------------------------------------------------------------

    template <class Number> std::string encoded(const std::vector<Number>& numbers)
    {
        std::string bytes(numbers.size() * sizeof(Number), '\0');
        std::memcpy(bytes.data(), numbers.data(), bytes.size());
        return base64(bytes);
    }

    std::string encoded_positions(const Points& points, const Box& box)
    {
        constexpr double kSteps = 65535.0;
        std::vector<std::uint16_t> steps;
        steps.reserve(static_cast<std::size_t>(points.size()));
        for (Eigen::Index v = 0; v < points.rows(); ++v)
            for (int axis = 0; axis < 3; ++axis) {
                const double share = (points(v, axis) - box.low[axis]) / (box.high[axis] - box.low[axis]);
                steps.push_back(static_cast<std::uint16_t>(std::lround(kSteps * std::clamp(share, 0.0, 1.0))));
            }
        return encoded(steps);
    }

    std::string encoded_triangles(const TriMesh& mesh)
    {
        std::vector<std::uint32_t> corners;
        corners.reserve(3 * mesh.triangles.size());
        for (const auto& triangle : mesh.triangles)
            for (const VertexId v : triangle)
                corners.push_back(static_cast<std::uint32_t>(v));
        return encoded(corners);
    }

    Box box_of(const std::vector<Part>& parts)
    {
        Eigen::AlignedBox3d box;
        for (const Part& part : parts)
            for (const Points* points : { &part.opened.vertices, &part.rest })
                for (Eigen::Index v = 0; v < points->rows(); ++v)
                    box.extend(Vec3(points->row(v).transpose()));
        const Vec3 margin = Vec3::Constant(1.0); // no axis has length zero
        return { .low = box.min() - margin, .high = box.max() + margin };
    }

    Json triple(const Vec3& v) { return { v.x(), v.y(), v.z() }; }

    Json camera_document(const Camera& camera)
    {
        return { { "eye", triple(camera.eye) }, { "aim", triple(camera.aim) }, { "up", triple(camera.up) },
            { "view_angle_deg", camera.view_angle_deg } };
    }

} // namespace

std::string field_view(planner::Patient& patient, const planner::PlannedField& field)
{
    Scene outside = overview_scene(patient, field);
    remove_vessels(outside); // they would stand still while the wound opens
    std::vector<Part> parts = parts_of(patient, field, outside);
    simplify(parts);
    for (Part& part : parts)
        if (part.layer == "target")
            colour_target(part, field.exposure);
    const Box box = box_of(parts);
    Json document { { "surgeon", camera_document(surgeon_scene(patient, field).camera) },
        { "outside", camera_document(outside.camera) },
        { "box", { { "low", triple(box.low) }, { "high", triple(box.high) } } } };
    document["layers"] = Json::array();
    for (const Layer& layer : kLayers)
        if (std::ranges::any_of(parts, [&](const Part& part) { return part.layer == layer.key; }))
            document["layers"].push_back({ { "key", layer.key }, { "name", layer.name } });
    document["surfaces"] = Json::array();
    for (const Part& part : parts) {
        if (part.opened.triangles.empty())
            continue;
        Json surface { { "layer", part.layer }, { "color", { part.color.r, part.color.g, part.color.b } },
            { "opacity", part.opacity }, { "triangles", encoded_triangles(part.opened) },
            { "opened", encoded_positions(part.opened.vertices, box) } };
        if (part.rest.rows() > 0)
            surface["rest"] = encoded_positions(part.rest, box);
        if (!part.seen.empty())
            surface["seen"] = encoded(part.seen);
        document["surfaces"].push_back(std::move(surface));
    }
    if (Json eyes = eyes_document(field.exposure); !eyes.is_null())
        document["eyes"] = std::move(eyes);
    return document.dump();
}

} // namespace retractor::ui
