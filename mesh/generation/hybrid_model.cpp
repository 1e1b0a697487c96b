#include "mesh/generation/hybrid_model.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/generation/cell_labels.h"
#include "mesh/generation/delaunay_mesher.h"
#include "mesh/generation/mesh_forecast.h"
#include "mesh/generation/mesh_polish.h"
#include "mesh/generation/mesh_statistics.h"
#include "mesh/generation/size_field.h"
#include "mesh/generation/surface_seeds.h"
#include "mesh/image/label_field.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>

namespace retractor::mesh {

namespace {

    void check_positive(double value, const char* name)
    {
        if (!std::isfinite(value) || value <= 0.0)
            throw InputError(std::string(name) + " must be positive, got " + std::to_string(value), name);
    }

    void check_input(const LabelVolume& labels, const MeshSizing& sizing)
    {
        check_grid(labels.grid);
        if (labels.voxels.size() != labels.grid.voxel_count())
            throw InputError("the label volume has " + std::to_string(labels.voxels.size()) + " voxels, its grid "
                + std::to_string(labels.grid.voxel_count()));
        if (labels.table.empty())
            throw InputError("the label table is empty");
        std::set<Label> ids;
        for (const LabelInfo& info : labels.table)
            if (!ids.insert(info.id).second)
                throw InputError("two entries of the label table have the id " + std::to_string(info.id), info.name);
        check_positive(sizing.corridor_edge_mm, "corridor_edge_mm");
        check_positive(sizing.coarse_edge_mm, "coarse_edge_mm");
        check_positive(sizing.fine_edge_mm, "fine_edge_mm");
        check_positive(sizing.corridor_radius_mm, "corridor_radius_mm");
        if (!std::isfinite(sizing.coarse_beyond_mm) || sizing.coarse_beyond_mm < 0.0)
            throw InputError(
                "coarse_beyond_mm must be zero or positive, got " + std::to_string(sizing.coarse_beyond_mm),
                "coarse_beyond_mm");
        if (sizing.coarse_beyond_mm > 0.0 && sizing.corridor.empty())
            throw InputError("coarse_beyond_mm needs a corridor", "coarse_beyond_mm");
        check_positive(sizing.coarse_path_edge_mm, "coarse_path_edge_mm");
        check_positive(sizing.coarse_path_radius_mm, "coarse_path_radius_mm");
        if (sizing.coarse_edge_mm < sizing.corridor_edge_mm)
            throw InputError("coarse_edge_mm must not be smaller than corridor_edge_mm", "coarse_edge_mm");
        if (!std::isfinite(sizing.region_mm) || sizing.region_mm < 0.0)
            throw InputError(
                "region_mm must be zero or positive, got " + std::to_string(sizing.region_mm), "region_mm");
        if (sizing.region_mm > 0.0 && sizing.corridor.empty())
            throw InputError("region_mm needs a corridor", "region_mm");
        for (std::size_t i = 0; i < sizing.corridor.size(); ++i)
            if (!sizing.corridor[i].allFinite())
                throw InputError("corridor point " + std::to_string(i) + " is not finite", "corridor");
        for (std::size_t i = 0; i < sizing.coarse_path.size(); ++i)
            if (!sizing.coarse_path[i].allFinite())
                throw InputError("coarse path point " + std::to_string(i) + " is not finite", "coarse_path");
    }

    // Degrees. Exudation leaves one element in a hundred below 12. The fit of interfaces may flatten elements to this
    // angle, and the raising of pits to the third; elements below are opened again afterwards.
    constexpr double kPolishAngle = 11.0;
    constexpr double kFlattestAngle = 9.0;
    constexpr double kRaisedAngle = 4.0;

    /// A piece with fewer elements, or with less volume than the cube of the fine edge, is no anatomy that can be cut
    /// or held.
    constexpr std::size_t kFewestTets = 12;

    /// Removes specks, and loose parts of whole labels that only graze the region, and reports the removal in
    /// `message`.
    void drop_loose_pieces(LocalMesh& mesh, double smallest_volume, const WallVoxels& wall, std::string& message)
    {
        RETRACTOR_ASSERT(!mesh.tets.empty() && mesh.labels.size() == mesh.tets.size());
        TetMesh whole;
        whole.vertices.resize(static_cast<Eigen::Index>(mesh.vertices.size()), 3);
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
            whole.vertices.row(static_cast<Eigen::Index>(v)) = mesh.vertices[v].transpose();
        for (const auto& tet : mesh.tets)
            whole.nodes.insert(whole.nodes.end(), tet.begin(), tet.end());
        whole.labels.assign(mesh.tets.size(), 1);
        const std::vector<int> piece = connected_pieces(whole);
        const auto pieces = static_cast<std::size_t>(*std::max_element(piece.begin(), piece.end()) + 1);
        std::vector<std::size_t> tets(pieces, 0);
        std::vector<double> volume(pieces, 0.0);
        std::vector<char> beyond_region_only(pieces, 1);
        for (std::size_t t = 0; t < piece.size(); ++t) {
            if (!wall.whole[mesh.labels[t] - 1U])
                beyond_region_only[static_cast<std::size_t>(piece[t])] = 0;
            ++tets[static_cast<std::size_t>(piece[t])];
            volume[static_cast<std::size_t>(piece[t])] += tet_volume(whole, static_cast<TetId>(t));
        }
        std::size_t dropped = 0, dropped_tets = 0;
        double dropped_volume = 0.0;
        std::vector<char> keep(pieces, 1);
        for (std::size_t p = 1; p < pieces; ++p)
            if (tets[p] < kFewestTets || volume[p] < smallest_volume || beyond_region_only[p]) {
                keep[p] = 0;
                ++dropped;
                dropped_tets += tets[p];
                dropped_volume += volume[p];
            }
        if (dropped == 0)
            return;
        std::size_t to = 0;
        for (std::size_t t = 0; t < piece.size(); ++t)
            if (keep[static_cast<std::size_t>(piece[t])]) {
                mesh.tets[to] = mesh.tets[t];
                mesh.labels[to++] = mesh.labels[t];
            }
        mesh.tets.resize(to);
        mesh.labels.resize(to);
        message = "dropped " + std::to_string(dropped) + " loose pieces (" + std::to_string(dropped_tets)
            + " tetrahedra, " + volume_text(dropped_volume) + ")";
    }

    /// Labels of the wall that are no bone or cartilage.
    std::vector<Label> soft_labels(const LabelTable& table)
    {
        std::vector<Label> soft;
        for (const LabelInfo& info : table)
            if (info.role == Role::wall && !is_skeleton(info))
                soft.push_back(info.id);
        return soft;
    }

    /// Gives the elements of the coarse model, which was meshed as one soft tissue, the soft label that fills most of
    /// each. An element without any keeps the label of the model.
    void give_soft_labels(LocalMesh& mesh, const LabelField& field)
    {
        for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
            std::array<Vec3, 4> corners;
            Vec3 middle = Vec3::Zero();
            for (std::size_t i = 0; i < 4; ++i) {
                corners[i] = mesh.vertices[static_cast<std::size_t>(mesh.tets[t][i])];
                middle += 0.25 * corners[i];
            }
            if (mesh.labels[t] != field.merged_number() || !field.merges_at(middle))
                continue; // no element of the coarse model
            std::vector<int> count(field.wall().labels.size() + 1, 0);
            for (const auto& weights : kCellSamples) {
                Vec3 at = Vec3::Zero();
                for (std::size_t i = 0; i < 4; ++i)
                    at += weights[i] * corners[i];
                if (const int number = field.unmerged_at(at); field.merges(number))
                    ++count[static_cast<std::size_t>(number)];
            }
            const auto most = std::max_element(count.begin(), count.end());
            if (*most > 0)
                mesh.labels[t] = static_cast<std::uint8_t>(most - count.begin());
        }
    }

    /// The mesh in patient LPS with the labels of the volume, without unused vertices.
    TetMesh world_mesh(const LocalMesh& local, const LabelVolume& labels, const WallVoxels& wall)
    {
        TetMesh mesh;
        std::vector<VertexId> number(local.vertices.size(), -1);
        std::vector<Vec3> used;
        const bool mirrored = labels.grid.direction.determinant() < 0.0;
        mesh.nodes.reserve(4 * local.tets.size());
        for (std::size_t t = 0; t < local.tets.size(); ++t) {
            std::array<VertexId, 4> tet = local.tets[t];
            if (mirrored)
                std::swap(tet[2], tet[3]);
            for (const VertexId v : tet) {
                VertexId& n = number[static_cast<std::size_t>(v)];
                if (n < 0) {
                    n = static_cast<VertexId>(used.size());
                    used.push_back(local.vertices[static_cast<std::size_t>(v)]);
                }
                mesh.nodes.push_back(n);
            }
            mesh.labels.push_back(wall.labels[static_cast<std::size_t>(local.labels[t] - 1)]);
        }
        mesh.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
        for (std::size_t v = 0; v < used.size(); ++v)
            mesh.vertices.row(static_cast<Eigen::Index>(v)) = world_point(labels.grid, used[v]).transpose();
        return mesh;
    }

    HybridModel without_mesh(MeshStatus status, std::string message)
    {
        HybridModel model;
        model.status = status;
        model.message = std::move(message);
        return model;
    }

} // namespace

HybridModel build_hybrid_model(const LabelVolume& labels, const MeshSizing& sizing, const Job& job,
    const std::function<void(double expected)>& on_forecast)
{
    check_input(labels, sizing);
    const Stopwatch watch;
    job.report("label field", 0.0);
    const std::vector<Vec3> corridor = local_points(labels.grid, sizing.corridor);
    const Region region { .corridor = local_points(labels.grid, region_line(sizing)),
        .region_mm = sizing.region_mm,
        .whole_labels = sizing.whole_labels,
        .merge_beyond_mm = sizing.coarse_beyond_mm,
        .merged_labels = soft_labels(labels.table) };
    const LabelField field(wall_voxels(labels, region), region);
    if (field.wall().empty())
        return without_mesh(MeshStatus::nothing_to_mesh, "no voxel of a wall label within the region");
    const SizeField size(field.wall(), labels.table, sizing, corridor, local_points(labels.grid, sizing.fine_places),
        local_points(labels.grid, sizing.coarse_path));
    const std::vector<SurfaceSeed> seeds = surface_seeds(field, size, sizing.seed);
    if (seeds.empty())
        return without_mesh(MeshStatus::nothing_to_mesh, "the wall labels vanish when smoothed");
    if (job.cancelled())
        return without_mesh(MeshStatus::cancelled, "cancelled");
    const double expected = expected_tetrahedra(field, size);
    if (on_forecast)
        on_forecast(expected);
    if (sizing.most_tetrahedra > 0.0 && expected > sizing.most_tetrahedra)
        throw InputError(formatted("these edge lengths make about %.2g tetrahedra, and %.2g are the most that fit: "
                                   "choose longer edges, or a smaller region",
                             expected, sizing.most_tetrahedra),
            "mesh sizes");

    job.report("refine tetrahedra", 0.0);
    LocalMesh local = delaunay_mesh(field, size, seeds, !sizing.deterministic, job);
    if (local.cancelled || job.cancelled())
        return without_mesh(MeshStatus::cancelled, "cancelled");
    if (local.tets.empty())
        return without_mesh(MeshStatus::nothing_to_mesh, "the wall labels are too small for the asked edge lengths");

    HybridModel model;
    model.expected_tetrahedra = expected;
    const Stopwatch polishing;
    open_flat_tets(local, field, kPolishAngle, job);
    raise_pits(local, field, kRaisedAngle, job);
    fit_interfaces(local, field, kPolishAngle, job);
    open_flat_tets(local, field, kFlattestAngle, job);
    local.optimise_seconds += polishing.seconds();
    if (job.cancelled())
        return without_mesh(MeshStatus::cancelled, "cancelled");
    if (sizing.coarse_beyond_mm > 0.0)
        give_soft_labels(local, field);
    drop_loose_pieces(local, std::pow(sizing.corridor_edge_mm, 3), field.wall(), model.message);
    model.wall = world_mesh(local, labels, field.wall());
    check_mesh(model.wall);
    job.report("mesh statistics", 0.0);
    model.statistics = mesh_statistics(model.wall, labels, field, { corridor, region.corridor }, sizing);
    model.statistics.refine_seconds = local.refine_seconds;
    model.statistics.optimise_seconds = local.optimise_seconds;
    model.statistics.total_seconds = watch.seconds();
    record_part(job, "tetrahedra", watch, model.statistics.bytes);
    job.report("mesh statistics", 1.0);
    return model;
}

} // namespace retractor::mesh
