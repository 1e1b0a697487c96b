#include "planner/wall/wall_cut.h"

#include "fem/model/floating_components.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/base/triangle.h"
#include "mesh/cutting/pieces.h"
#include "planner/approach/hook_patches.h"
#include "planner/wall/division_cut.h"
#include "planner/wall/field_geometry.h"
#include "planner/wall/rib_joints.h"
#include "planner/wall/supports.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <set>

namespace retractor::planner {

namespace {

    constexpr double kCrumbMm3 = 1.0; ///< smaller than any piece that a knife leaves on purpose

    std::string label_name(const mesh::LabelTable& table, Label label)
    {
        const mesh::LabelInfo* info = mesh::find_label(table, label);
        return info != nullptr ? info->name : "label " + std::to_string(label);
    }

    // ---- ablations -------------------------------------------------------------------------------------------------

    /// Makes blades on and beside the incision's blade.
    class BesideBlade {
    public:
        explicit BesideBlade(const Approach& approach)
            : approach_(approach)
            , blade_(blade_of(approach))
        {
        }
        const mesh::SweptBlade& blade() const { return blade_; }
        Vec3 direction(double along) const
        {
            return (blade_.at(along, blade_.depth()) - blade_.at(along, 0.0)).normalized();
        }
        Vec3 point(double along, double aside) const
        {
            const double step = 0.5 * std::min(1.0, blade_.length());
            const Vec3 tangent = blade_.at(along + step, 0.0) - blade_.at(along - step, 0.0);
            return blade_.at(along, 0.0) + aside * (-direction(along)).cross(tangent).normalized();
        }
        /// A blade that follows the incision at a distance, with its bends.
        mesh::Blade beside(double aside, double from, double to) const
        {
            std::vector<double> places { from };
            double along = 0.0;
            for (std::size_t n = 1; n + 1 < approach_.incision.size(); ++n) {
                along += (approach_.incision[n] - approach_.incision[n - 1]).norm();
                if (along > from + kShortestMm && along < to - kShortestMm)
                    places.push_back(along);
            }
            places.push_back(to);
            mesh::Blade saw { .line = {}, .directions = {}, .depth_mm = approach_.depth_mm };
            for (const double place : places) {
                saw.line.push_back(point(place, aside));
                saw.directions.push_back(direction(place));
            }
            return saw;
        }
        /// A blade across the incision.
        mesh::Blade across(double along, double from, double to) const
        {
            return { .line = { point(along, from), point(along, to) },
                .directions = { direction(along) },
                .depth_mm = approach_.depth_mm };
        }

    private:
        static constexpr double kShortestMm = 0.5; ///< shortest line of a saw
        const Approach& approach_;
        mesh::SweptBlade blade_;
    };

    /// Area (mm^2) of these elements on the surface through which the blade entered. Wounds do not count.
    double skin_area(const mesh::CutSession& session, const std::vector<TetId>& marked, const mesh::SweptBlade& blade)
    {
        std::set<std::pair<TetId, int>> wound;
        for (const mesh::LipFace& lip : session.lips())
            wound.emplace(lip.face.tet, lip.face.corner);
        const std::set<TetId> taken(marked.begin(), marked.end());
        mesh::SlotMap map;
        const mesh::TetMesh mesh = session.compact_mesh(&map);
        double area = 0.0;
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
            const TetId slot = map.tet_slot[static_cast<std::size_t>(face.tet)];
            if (!taken.contains(slot) || wound.contains({ slot, face.corner }) || !faces_blade(mesh, face, blade))
                continue;
            area += triangle_area(mesh.vertices, mesh::face_vertices(mesh, face));
        }
        return area;
    }

    class Knife {
    public:
        Knife(mesh::CutSession& session, const mesh::LabelTable& table, const Job& job, PlannedCut& planned)
            : session_(session)
            , table_(table)
            , job_(job)
            , planned_(planned)
        {
        }

        void ablate(const Approach& approach, const AblationSpec& ablation)
        {
            const BesideBlade places(approach);
            const std::string text = ablation_text(ablation, places.blade().length());
            const std::vector<TetId> marked = ablation.is_ball()
                ? mesh::mark_ball(session_, ablation.centre, ablation.radius_mm, labels(ablation))
                : sawn_segment(places, ablation, text);
            if (planned_.status == mesh::CutStatus::cancelled)
                return;
            if (marked.empty())
                throw InputError("there is no " + text + " in the meshed wall" + whereabouts(places, ablation));
            std::map<Label, double> volume;
            for (const TetId t : marked) {
                const mesh::MeshDelta::Tet tet = session_.tet(t);
                volume[tet.label] += mesh::tet_volume(session_.position(tet.nodes[0]), session_.position(tet.nodes[1]),
                    session_.position(tet.nodes[2]), session_.position(tet.nodes[3]));
            }
            const double skin_mm2 = skin_area(session_, marked, places.blade());
            keep(session_.ablate(marked, job_));
            if (planned_.status == mesh::CutStatus::cancelled)
                return;
            planned_.removed_skin_mm2 += skin_mm2;
            for (const auto& [label, mm3] : volume)
                planned_.removed.push_back({ text, label_name(table_, label), mm3 });
        }

        void keep(mesh::CutResult result)
        {
            if (result.status == mesh::CutStatus::done)
                planned_.deltas.push_back(std::move(result.delta));
            else if (result.status == mesh::CutStatus::cancelled) {
                planned_.status = mesh::CutStatus::cancelled;
                planned_.message = result.message;
            }
        }

    private:
        std::vector<Label> labels(const AblationSpec& ablation) const
        {
            if (ablation.label.empty())
                return {};
            return { mesh::label_named(table_, ablation.label).id };
        }

        /// The middle of an element in the coordinates of the blade.
        mesh::BladeCoordinates coordinates_of(const BesideBlade& places, TetId t) const
        {
            Vec3 centroid = Vec3::Zero();
            for (const VertexId v : session_.tet(t).nodes)
                centroid += 0.25 * session_.position(v);
            return places.blade().coordinates(centroid);
        }

        /// Where a segment's label lies beside the incision; empty for a ball.
        std::string whereabouts(const BesideBlade& places, const AblationSpec& ablation) const
        {
            if (ablation.is_ball())
                return {};
            const Label label = labels(ablation).front();
            Eigen::AlignedBox2d box; // along, across
            for (TetId t = 0; t < static_cast<TetId>(session_.tet_slots()); ++t) {
                if (!session_.has_tet(t) || session_.tet(t).label != label)
                    continue;
                const mesh::BladeCoordinates c = coordinates_of(places, t);
                if (c.depth < places.blade().depth() && c.along > 0.0 && c.along < places.blade().length())
                    box.extend(Eigen::Vector2d(c.along, c.side));
            }
            if (box.isEmpty())
                return ": the blade does not pass beside " + ablation.label;
            return formatted(": beside the blade %s lies %.0f to %.0f mm across and %.0f to %.0f mm along the incision",
                ablation.label.c_str(), box.min().y(), box.max().y(), box.min().x(), box.max().x());
        }

        void remark_unsawn(const std::string& text, const Error& error)
        {
            remark(planned_.message,
                text + " could not be sawn through on one side (" + error.what()
                    + "): there it ends at whole elements");
        }

        /// Saws the label at the four sides of the segment, where the label is there. @returns the elements of the
        /// segment
        std::vector<TetId> sawn_segment(
            const BesideBlade& places, const AblationSpec& ablation, const std::string& text)
        {
            const std::vector<Label> label = labels(ablation);
            RETRACTOR_ASSERT(label.size() == 1); // check_approach() refuses a segment without a label
            const double from = ablation.along_from_mm.value_or(0.0),
                         to = ablation.along_to_mm.value_or(places.blade().length());
            mesh::CutOptions options;
            for (const mesh::LabelInfo& info : table_)
                if (info.id != label.front())
                    options.uncut_labels.push_back(info.id);
            for (const mesh::Blade& saw : { places.beside(ablation.from_mm, from, to),
                     places.beside(ablation.to_mm, from, to), places.across(from, ablation.from_mm, ablation.to_mm),
                     places.across(to, ablation.from_mm, ablation.to_mm) })
                try {
                    keep(session_.cut(saw, options, job_));
                    if (planned_.status == mesh::CutStatus::cancelled)
                        return {};
                    // An IoError does not come from the saw and is not caught.
                } catch (const InputError& error) {
                    remark_unsawn(text, error);
                } catch (const SolverError& error) {
                    remark_unsawn(text, error);
                }
            std::vector<TetId> marked;
            for (TetId t = 0; t < static_cast<TetId>(session_.tet_slots()); ++t) {
                if (!session_.has_tet(t) || session_.tet(t).label != label.front())
                    continue;
                const mesh::BladeCoordinates c = coordinates_of(places, t);
                if (c.along > from && c.along < to && c.side > ablation.from_mm && c.side < ablation.to_mm
                    && c.depth < places.blade().depth())
                    marked.push_back(t);
            }
            return marked;
        }

        mesh::CutSession& session_;
        const mesh::LabelTable& table_;
        const Job& job_;
        PlannedCut& planned_;
    };

    // ---- supports over a cut ----

    /// Carries supports, by the ids of a session, from delta to delta. A copy of a fixed vertex is fixed, and so is a
    /// new vertex on an edge between two fixed ones. A vertex on a bed shares the bed with its copies. A hinge keeps
    /// the edges whose vertices live. Deltas are only followed forwards: vertices that come back when an ablation is
    /// undone get no support.
    class CarriedSupports {
    public:
        explicit CarriedSupports(const fem::Supports& uncut)
        {
            fixed_.insert(uncut.fixed.begin(), uncut.fixed.end());
            for (const fem::BeddedVertex& bedded : uncut.bedded)
                bed_[bedded.vertex] = bedded.stiffness;
            hinges_ = uncut.hinges;
        }
        void follow(const mesh::MeshDelta& delta)
        {
            for (const auto& born : delta.vertices_born) {
                if (fixed_.contains(born.a) && fixed_.contains(born.b))
                    fixed_.insert(born.id);
                if (const auto bed = bed_.find(born.a);
                    bed != bed_.end() && born.origin == mesh::MeshDelta::Origin::copy) {
                    bed->second *= 0.5;
                    const double half = bed->second;
                    bed_[born.id] = half;
                }
            }
            for (const auto& gone : delta.vertices_gone) {
                fixed_.erase(gone.id);
                bed_.erase(gone.id);
            }
            std::set<VertexId> gone;
            for (const auto& vertex : delta.vertices_gone)
                gone.insert(vertex.id);
            if (!gone.empty())
                for (fem::Hinge& hinge : hinges_)
                    std::erase_if(hinge.edges,
                        [&](const fem::HingeEdge& edge) { return gone.contains(edge.a) || gone.contains(edge.b); });
        }
        fem::Supports compact(const mesh::SlotMap& map) const
        {
            fem::Supports supports;
            for (const VertexId v : fixed_)
                supports.fixed.push_back(map.compact_vertex[static_cast<std::size_t>(v)]);
            for (const auto& [v, stiffness] : bed_)
                supports.bedded.push_back({ map.compact_vertex[static_cast<std::size_t>(v)], stiffness });
            supports.hinges = hinges_;
            for (fem::Hinge& hinge : supports.hinges)
                for (fem::HingeEdge& edge : hinge.edges)
                    edge = { map.compact_vertex[static_cast<std::size_t>(edge.a)],
                        map.compact_vertex[static_cast<std::size_t>(edge.b)], edge.share };
            return supports;
        }

    private:
        std::set<VertexId> fixed_;
        std::map<VertexId, double> bed_;
        std::vector<fem::Hinge> hinges_;
    };

    // ---- loose pieces ----

    std::vector<VertexId> vertices_of(const mesh::TetMesh& mesh, std::span<const TetId> tets)
    {
        std::set<VertexId> vertices;
        for (const TetId t : tets)
            for (const VertexId v : mesh.tet(t))
                vertices.insert(v);
        return { vertices.begin(), vertices.end() };
    }

    /// Takes the compact state of the session: mesh, lips, supports, hooks and pieces.
    mesh::SlotMap take(CutWall& cut, const mesh::CutSession& session, const CarriedSupports& supports,
        const Approach& approach, const mesh::LabelTable& table)
    {
        mesh::SlotMap map;
        cut.wall = session.compact_mesh(&map);
        RETRACTOR_ASSERT(map.tet_slot.size() == cut.wall.tet_count());
        cut.lips.clear();
        cut.wound.clear();
        for (mesh::LipFace lip : session.lips()) {
            lip.face.tet = map.compact_tet[static_cast<std::size_t>(lip.face.tet)];
            cut.wound.push_back(lip.face);
            if (lip.cut == 0 && lip.side != 0) // saws and bared faces hold no hook
                cut.lips.push_back(lip);
        }
        cut.origin.clear();
        for (const TetId slot : map.tet_slot)
            cut.origin.push_back(session.origin(slot));
        cut.supports = supports.compact(map);
        cut.supports.hinges = fem::joined_hinges(cut.wall, std::move(cut.supports.hinges));
        cut.hooks = hook_patches(cut.wall, cut.lips, approach, table, cut.supports);
        // A blade in contact does not hold a piece that lies loose.
        std::vector<fem::HookPatch> holding;
        for (std::size_t h = 0; h < cut.hooks.size(); ++h)
            if (approach.hooks[h].hold == HookHold::fixed)
                holding.push_back(cut.hooks[h]);
        cut.pieces = find_wall_pieces(cut.wall, table, cut.supports, holding);
        return map;
    }

    /// Adds a bed under the whole surface of the piece.
    void bed(CutWall& cut, const WallPiece& piece)
    {
        std::set<TetId> own(piece.tets.begin(), piece.tets.end());
        std::map<VertexId, double> stiffness;
        for (const mesh::TetFace& face : mesh::boundary_faces(cut.wall)) {
            if (!own.contains(face.tet))
                continue;
            const auto v = mesh::face_vertices(cut.wall, face);
            const double share = triangle_area(cut.wall.vertices, v) / 3.0;
            for (const VertexId corner : v)
                stiffness[corner] += kBedModulus * share;
        }
        for (const VertexId v : cut.supports.fixed)
            stiffness.erase(v);
        for (const fem::BeddedVertex& bedded : cut.supports.bedded)
            stiffness.erase(bedded.vertex);
        for (const auto& [v, k] : stiffness)
            cut.supports.bedded.push_back({ v, k });
    }

    /// Leaves the piece out of the elastic solution: its vertices are fixed there, unless other pieces or hooks share
    /// them.
    void make_rigid(CutWall& cut, const WallPiece& piece)
    {
        std::vector<VertexId> vertices = vertices_of(cut.wall, piece.tets);
        std::vector<bool> own(cut.wall.tet_count(), false), shared(cut.wall.vertex_count(), false);
        for (const TetId t : piece.tets)
            own[static_cast<std::size_t>(t)] = true;
        for (TetId t = 0; t < static_cast<TetId>(cut.wall.tet_count()); ++t)
            if (!own[static_cast<std::size_t>(t)])
                for (const VertexId v : cut.wall.tet(t))
                    shared[static_cast<std::size_t>(v)] = true;
        for (const fem::HookPatch& hook : cut.hooks)
            for (const VertexId v : hook.nodes)
                shared[static_cast<std::size_t>(v)] = true;
        std::erase_if(vertices, [&](VertexId v) { return shared[static_cast<std::size_t>(v)]; });
        cut.supports.fixed.insert(cut.supports.fixed.end(), vertices.begin(), vertices.end());
        std::sort(cut.supports.fixed.begin(), cut.supports.fixed.end());
        cut.supports.fixed.erase(
            std::unique(cut.supports.fixed.begin(), cut.supports.fixed.end()), cut.supports.fixed.end());
        std::erase_if(cut.supports.bedded, [&](const fem::BeddedVertex& bedded) {
            return std::binary_search(vertices.begin(), vertices.end(), bedded.vertex);
        });
        cut.rigid.push_back(std::move(vertices));
    }

    /// Notes which of the pieces to be removed bear faces of which lip.
    void note_lost_lips(CutWall& cut, const std::vector<WallPiece>& removed)
    {
        for (const WallPiece& piece : removed) {
            std::array<bool, 2> bears {};
            for (const mesh::LipFace& lip : cut.lips)
                if (std::binary_search(piece.tets.begin(), piece.tets.end(), lip.face.tet))
                    bears[lip.side > 0 ? 0 : 1] = true;
            for (std::size_t side = 0; side < 2; ++side)
                if (bears[side] && !is_crumb(piece))
                    remark(cut.took_lip[side], piece_text(piece));
        }
    }

    void deal_with_loose(CutWall& cut, mesh::CutSession& session, CarriedSupports& supports, const Approach& approach,
        const mesh::LabelTable& table, const mesh::SlotMap& map, const Job& job)
    {
        std::vector<WallPiece> loose;
        for (const WallPiece& piece : cut.pieces)
            if (!piece.held)
                loose.push_back(piece);
        if (loose.empty() || loose.size() == cut.pieces.size()) // when nothing holds anything, the solver reports it
            return;
        const std::map<LoosePieces, std::string> fate { { LoosePieces::held, "held on a soft bed" },
            { LoosePieces::removed, "removed" }, { LoosePieces::rigid, "left rigid" } };
        std::size_t crumbs = 0;
        for (const WallPiece& piece : loose)
            if (is_crumb(piece))
                ++crumbs;
            else
                cut.loose.push_back(piece_text(piece) + " has no support: " + fate.at(approach.loose_pieces));
        if (crumbs > 0)
            cut.loose.push_back(crumbs_text(crumbs) + " without support: " + fate.at(approach.loose_pieces));
        for (const std::string& text : cut.loose)
            remark(cut.message, text);
        if (approach.loose_pieces == LoosePieces::removed) {
            std::vector<TetId> marked;
            for (const WallPiece& piece : loose) {
                for (const TetId t : piece.tets)
                    marked.push_back(map.tet_slot[static_cast<std::size_t>(t)]);
                for (const auto& [label, mm3] : piece.labels)
                    cut.removed.push_back({ "a loose piece", label, mm3 });
            }
            note_lost_lips(cut, loose);
            cut.removed_skin_mm2 += skin_area(session, marked, mesh::SweptBlade(blade_of(approach)));
            const mesh::CutResult result = session.ablate(marked, job);
            cut.status = result.status;
            supports.follow(result.delta);
            take(cut, session, supports, approach, table);
            return;
        }
        for (const WallPiece& piece : loose)
            if (approach.loose_pieces == LoosePieces::held)
                bed(cut, piece);
            else
                make_rigid(cut, piece);
    }

    /// The rigid motion x -> R x + t that takes `from` to `to` best [Kabsch 1976]; a translation when there are too few
    /// points.
    Eigen::Isometry3d best_motion(const std::vector<Vec3>& from, const std::vector<Vec3>& to)
    {
        RETRACTOR_ASSERT(from.size() == to.size());
        Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
        if (from.empty())
            return motion;
        Vec3 a = Vec3::Zero(), b = Vec3::Zero();
        for (std::size_t i = 0; i < from.size(); ++i) {
            a += from[i] / static_cast<double>(from.size());
            b += to[i] / static_cast<double>(from.size());
        }
        Mat3 spread = Mat3::Zero(), turn = Mat3::Zero();
        for (std::size_t i = 0; i < from.size(); ++i) {
            spread += (from[i] - a) * (from[i] - a).transpose();
            turn += (to[i] - b) * (from[i] - a).transpose();
        }
        const Vec3 extent = Eigen::JacobiSVD<Mat3>(spread).singularValues();
        // Square of width over length; narrower point sets do not determine the rotation.
        constexpr double kOnLine = 1e-6;
        if (extent[1] > kOnLine * extent[0]) {
            const Eigen::JacobiSVD<Mat3> svd(turn, Eigen::ComputeFullU | Eigen::ComputeFullV);
            Vec3 sign(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0);
            motion.linear() = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
        }
        motion.translation() = b - motion.linear() * a;
        return motion;
    }

} // namespace

PlannedCut cut_as_planned(mesh::CutSession& session, const Approach& approach, const mesh::LabelTable& table,
    const mesh::CutOptions& options, const Job& job)
{
    PlannedCut planned;
    const std::size_t cuts_before = session.cut_count();
    mesh::CutResult cut = session.cut(blade_of(approach), options, job);
    planned.status = cut.status;
    planned.message = cut.message;
    planned.report = cut.report;
    if (cut.status != mesh::CutStatus::done)
        return planned;
    planned.deltas.push_back(std::move(cut.delta));
    DivisionCut division = divide_beyond_skin(session, approach, table, job);
    planned.status = division.status;
    planned.divided = std::move(division.divided);
    std::move(division.deltas.begin(), division.deltas.end(), std::back_inserter(planned.deltas));
    if (planned.status == mesh::CutStatus::cancelled)
        planned.message = "the cut was cancelled";
    Knife knife(session, table, job, planned);
    for (std::size_t n = 0; n < approach.ablations.size() && planned.status == mesh::CutStatus::done; ++n)
        try {
            knife.ablate(approach, approach.ablations[n]);
        } catch (const InputError& error) {
            throw InputError(error.what(), "ablations/" + std::to_string(n));
        }
    if (planned.status == mesh::CutStatus::cancelled) {
        while (session.cut_count() > cuts_before)
            static_cast<void>(session.undo());
        planned.deltas.clear();
        planned.divided.reset();
        planned.removed.clear();
        planned.removed_skin_mm2 = 0.0;
    }
    return planned;
}

fem::Supports supports_of(const mesh::TetMesh& wall, const mesh::LabelVolume& labels, const Case& planned_case,
    const mesh::MeshSizing& sizing, std::string* message)
{
    const std::vector<Label> fixed_labels = mesh::label_ids(planned_case.label_table, planned_case.supports.labels);
    fem::Supports supports { .fixed
        = wall_supports(wall, labels, fixed_labels, sizing.whole_labels, planned_case.supports.region_border),
        .bedded = girdle_beds(wall, labels, sizing.whole_labels) };
    std::set<VertexId> held(supports.fixed.begin(), supports.fixed.end());
    for (const fem::BeddedVertex& bed : supports.bedded)
        held.insert(bed.vertex);
    RibJoints joints = rib_joints(wall, labels, fixed_labels);
    for (const fem::BeddedVertex& spring : joints.springs)
        if (!held.contains(spring.vertex))
            supports.bedded.push_back(spring);
    if (message != nullptr)
        if (const std::string text = guessed_joints_text(joints); !text.empty())
            remark(*message, text);
    supports.hinges = std::move(joints.hinges);
    return supports;
}

fem::Supports carried_supports(
    const fem::Supports& uncut, std::span<const mesh::MeshDelta> deltas, const mesh::SlotMap& map)
{
    CarriedSupports carried(uncut);
    for (const mesh::MeshDelta& delta : deltas)
        carried.follow(delta);
    return carried.compact(map);
}

std::vector<WallPiece> find_wall_pieces(const mesh::TetMesh& wall, const mesh::LabelTable& table,
    const fem::Supports& supports, std::span<const fem::HookPatch> hooks)
{
    const std::vector<int> number = mesh::connected_pieces(wall);
    RETRACTOR_ASSERT(number.size() == wall.tet_count() && wall.labels.size() == wall.tet_count());
    std::vector<VertexId> held = supports.fixed;
    for (const fem::BeddedVertex& bedded : supports.bedded)
        held.push_back(bedded.vertex);
    for (const fem::HookPatch& hook : hooks)
        held.insert(held.end(), hook.nodes.begin(), hook.nodes.end());
    const std::vector<std::uint8_t> is_held = fem::held_components(wall, number, held);
    std::vector<WallPiece> pieces(is_held.size());
    std::vector<std::map<Label, double>> volumes(pieces.size());
    std::vector<int> piece_of_vertex(wall.vertex_count(), -1);
    for (TetId t = 0; t < static_cast<TetId>(wall.tet_count()); ++t) {
        const auto p = static_cast<std::size_t>(number[static_cast<std::size_t>(t)]);
        const double volume = mesh::tet_volume(wall, t);
        pieces[p].tets.push_back(t);
        pieces[p].volume_mm3 += volume;
        volumes[p][wall.labels[static_cast<std::size_t>(t)]] += volume;
        for (const VertexId v : wall.tet(t)) {
            pieces[p].centroid += 0.25 * volume * wall.vertices.row(v).transpose();
            piece_of_vertex[static_cast<std::size_t>(v)] = static_cast<int>(p);
        }
    }
    const auto piece_with = [&](VertexId v) -> WallPiece& {
        return pieces[static_cast<std::size_t>(piece_of_vertex[static_cast<std::size_t>(v)])];
    };
    for (const VertexId v : supports.fixed)
        ++piece_with(v).fixed;
    for (const fem::BeddedVertex& bedded : supports.bedded)
        ++piece_with(bedded.vertex).bedded;
    for (const fem::HookPatch& hook : hooks) {
        std::set<int> of_hook;
        for (const VertexId v : hook.nodes)
            of_hook.insert(piece_of_vertex[static_cast<std::size_t>(v)]);
        for (const int p : of_hook)
            pieces[static_cast<std::size_t>(p)].hooks.push_back(hook.name);
    }
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        pieces[p].number = static_cast<int>(p) + 1;
        pieces[p].centroid /= pieces[p].volume_mm3;
        pieces[p].held = is_held[p] != 0;
        for (const auto& [label, volume] : volumes[p])
            pieces[p].labels.emplace_back(label_name(table, label), volume);
        std::stable_sort(pieces[p].labels.begin(), pieces[p].labels.end(),
            [](const auto& a, const auto& b) { return a.second > b.second; });
    }
    return pieces;
}

std::string piece_text(const WallPiece& piece)
{
    std::string names;
    for (const auto& [name, volume] : piece.labels)
        if (names.empty() || volume > 0.1 * piece.volume_mm3) // crumbs of other tissue need no name
            names += (names.empty() ? "" : ", ") + name;
    return "piece " + std::to_string(piece.number) + ": " + volume_text(piece.volume_mm3) + " of " + names
        + formatted(" at (%.0f, %.0f, %.0f) mm", piece.centroid.x(), piece.centroid.y(), piece.centroid.z());
}

bool is_crumb(const WallPiece& piece) { return piece.volume_mm3 < kCrumbMm3; }

std::string crumbs_text(std::size_t count)
{
    RETRACTOR_ASSERT(count > 0);
    return std::to_string(count) + (count == 1 ? " crumb" : " crumbs") + " below " + formatted("%.0f mm3", kCrumbMm3);
}

CutWall cut_wall(mesh::TetMesh uncut, const Approach& approach, const mesh::LabelTable& table, fem::Supports supports,
    const Job& job)
{
    CutWall cut;
    CarriedSupports carried(supports);
    mesh::CutSession session(std::move(uncut));
    PlannedCut planned = cut_as_planned(session, approach, table, cut_options_of(approach, table), job);
    cut.status = planned.status;
    cut.message = std::move(planned.message);
    cut.divided = std::move(planned.divided);
    cut.removed = std::move(planned.removed);
    cut.removed_skin_mm2 = planned.removed_skin_mm2;
    if (cut.status != mesh::CutStatus::done)
        return cut;
    for (const mesh::MeshDelta& delta : planned.deltas)
        carried.follow(delta);
    const mesh::SlotMap map = take(cut, session, carried, approach, table);
    deal_with_loose(cut, session, carried, approach, table, map, job);
    return cut;
}

void move_rigid_pieces(const mesh::TetMesh& wall, std::span<const std::vector<VertexId>> rigid, Points& displacement)
{
    if (rigid.empty())
        return;
    RETRACTOR_ASSERT(displacement.rows() == wall.vertices.rows());
    std::vector<bool> is_rigid(wall.vertex_count(), false);
    for (const auto& vertices : rigid)
        for (const VertexId v : vertices)
            is_rigid[static_cast<std::size_t>(v)] = true;
    // The two copies of a vertex on a lip lie in the same place, to the last bit.
    std::map<std::array<double, 3>, std::vector<VertexId>> others;
    const auto place = [&](VertexId v) {
        return std::array<double, 3> { wall.vertices(v, 0), wall.vertices(v, 1), wall.vertices(v, 2) };
    };
    for (VertexId v = 0; v < static_cast<VertexId>(wall.vertex_count()); ++v)
        if (!is_rigid[static_cast<std::size_t>(v)])
            others[place(v)].push_back(v);
    for (const auto& vertices : rigid) {
        std::vector<Vec3> from, to;
        for (const VertexId v : vertices)
            if (const auto twins = others.find(place(v)); twins != others.end())
                for (const VertexId twin : twins->second) {
                    from.push_back(wall.vertices.row(twin).transpose());
                    to.push_back((wall.vertices.row(twin) + displacement.row(twin)).transpose());
                }
        const Eigen::Isometry3d motion = best_motion(from, to);
        for (const VertexId v : vertices) {
            const Vec3 rest = wall.vertices.row(v).transpose();
            displacement.row(v) = (motion * rest - rest).transpose();
        }
    }
}

} // namespace retractor::planner
