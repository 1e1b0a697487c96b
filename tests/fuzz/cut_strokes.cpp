#include "tests/fuzz/cut_strokes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace retractor::fuzz {

namespace {

    /// Offsets (in mean edges) from what a blade grazes: exactly on it, within round-off, near the snapping bounds.
    constexpr std::array<double, 8> kGrazes { 0.0, 0.0, 1e-14, 1e-11, 1e-9, 1e-6, 1e-3, 0.05 };

    class Maker {
    public:
        Maker(const Body& body, const mesh::CutSession& session, const State& now, std::mt19937_64& random)
            : body_(body)
            , session_(session)
            , random_(random)
            , map_(now.map)
            , mesh_(now.mesh)
            , faces_(now.boundary)
        {
            size_ = (body.mesh.vertices.colwise().maxCoeff() - body.mesh.vertices.colwise().minCoeff()).norm();
        }

        double uniform(double low, double high)
        {
            return low + (high - low) * std::generate_canonical<double, 53>(random_);
        }
        std::size_t index(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
        bool chance(double p) { return uniform(0.0, 1.0) < p; }
        double edge() const { return body_.edge; }
        double size() const { return size_; }
        Vec3 at(VertexId v) const { return mesh_.vertices.row(v).transpose(); }

        Vec3 unit_vector()
        {
            Vec3 v;
            do {
                for (int axis = 0; axis < 3; ++axis)
                    v[axis] = uniform(-1, 1);
            } while (v.norm() > 1.0 || v.norm() < 0.1);
            return v.normalized();
        }

        struct Place {
            Vec3 point, normal;
        };
        Place on_surface()
        {
            const auto v = mesh::face_vertices(mesh_, faces_[index(faces_.size())]);
            const Vec3 a = at(v[0]), b = at(v[1]), c = at(v[2]);
            double s = uniform(0, 1), t = uniform(0, 1);
            if (s + t > 1.0) {
                s = 1.0 - s;
                t = 1.0 - t;
            }
            return { a + s * (b - a) + t * (c - a), (b - a).cross(c - a).normalized() };
        }

        /// A blade that goes in at a place of the surface.
        mesh::Blade from_surface(double length, double depth, int points, double turn)
        {
            const Place place = on_surface();
            const double lean = uniform(0, 0.6);
            const Vec3 in = (-place.normal + lean * unit_vector()).normalized();
            Vec3 along = unit_vector().cross(in).normalized();
            mesh::Blade blade;
            std::vector<Vec3> line { Vec3::Zero() };
            for (int i = 1; i < points; ++i) {
                line.push_back(line.back() + length / (points - 1) * along);
                along = Eigen::AngleAxisd(turn * uniform(0.5, 1.0), in) * along;
            }
            const Vec3 middle = line[line.size() / 2];
            for (Vec3& p : line)
                p += place.point - middle;
            blade.line = std::move(line);
            blade.directions = { in };
            blade.depth_mm = depth;
            blade.above_mm = chance(0.2) ? uniform(0.0, edge()) : std::max(10.0, length);
            return blade;
        }

        /// A blade in the plane of three points, within round-off or a little off.
        mesh::Blade in_plane(const std::array<Vec3, 3>& p, double length, double depth)
        {
            const Vec3 along = (p[1] - p[0]).normalized();
            const Vec3 normal = along.cross(p[2] - p[0]).normalized();
            const double graze = kGrazes[index(kGrazes.size())] * edge();
            const Vec3 shift = graze * (chance(0.5) ? normal : unit_vector());
            Vec3 in = normal.cross(along);
            if (chance(0.5))
                in = (in + uniform(-0.7, 0.7) * along).normalized();
            const double before = uniform(-0.2, 1.0) * length;
            mesh::Blade blade;
            blade.line = { p[0] - before * along + shift, p[0] + (length - before) * along + shift };
            blade.directions = { in };
            if (chance(0.5)) { // the line above the plane's points, and the front through them now and then
                const double up = uniform(0.0, 2.0) * edge();
                for (Vec3& q : blade.line)
                    q -= up * in;
                depth = chance(0.3) ? up : depth;
            }
            blade.depth_mm = std::max(depth, 1e-3 * edge());
            blade.above_mm = size();
            return blade;
        }

        std::array<Vec3, 3> face_of_mesh(bool interface)
        {
            for (int tries = 0; tries < 200; ++tries) {
                const auto t = static_cast<TetId>(index(mesh_.tet_count()));
                if (interface && !on_interface(t))
                    continue;
                const auto v = mesh::face_vertices(mesh_, { t, static_cast<int>(index(4)) });
                return { at(v[0]), at(v[1]), at(v[2]) };
            }
            const auto v = mesh::face_vertices(mesh_, faces_[index(faces_.size())]);
            return { at(v[0]), at(v[1]), at(v[2]) };
        }

        bool on_interface(TetId t) const
        {
            // A neighbour by vertex is enough: the stroke is aimed near, not at, the interface then.
            const auto n = mesh_.tet(t);
            for (TetId other = std::max(0, t - 8); other < std::min(static_cast<TetId>(mesh_.tet_count()), t + 8);
                 ++other)
                if (mesh_.labels[static_cast<std::size_t>(other)] != mesh_.labels[static_cast<std::size_t>(t)])
                    for (const VertexId v : mesh_.tet(other))
                        if (std::find(n.begin(), n.end(), v) != n.end())
                            return true;
            return false;
        }

        /// From a face of an earlier wound; across it, or starting or ending at it.
        mesh::Blade at_wound(bool across)
        {
            const std::vector<mesh::LipFace> lips = session_.lips();
            if (lips.empty()) {
                const double length = uniform(0.2, 0.8) * size();
                const double depth = uniform(0.5, 4.0) * edge();
                return from_surface(length, depth, 2, 0.0);
            }
            const mesh::LipFace& lip = lips[index(lips.size())];
            const auto v = mesh::face_vertices(
                mesh_, { map_.compact_tet[static_cast<std::size_t>(lip.face.tet)], lip.face.corner });
            const Vec3 normal = (at(v[1]) - at(v[0])).cross(at(v[2]) - at(v[0])).normalized();
            const Vec3 point = chance(0.5) ? at(v[index(3)]) : Vec3((at(v[0]) + at(v[1]) + at(v[2])) / 3.0);
            const double lean = uniform(0.0, 0.8);
            const Vec3 along = (normal + lean * unit_vector()).normalized();
            const Vec3 in = unit_vector().cross(along).normalized();
            const double length = uniform(0.5, 6.0) * edge();
            const double up = uniform(0.0, 3.0) * edge();
            const double before = across ? uniform(0.1, 0.9) * length : 0.0;
            mesh::Blade blade;
            blade.line = { point - before * along - up * in, point + (length - before) * along - up * in };
            if (chance(0.5))
                std::swap(blade.line[0], blade.line[1]);
            blade.directions = { in };
            blade.depth_mm = up + uniform(0.2, 3.0) * edge();
            blade.above_mm = size();
            return blade;
        }

    private:
        const Body& body_;
        const mesh::CutSession& session_;
        std::mt19937_64& random_;
        const mesh::SlotMap& map_;
        const mesh::TetMesh& mesh_;
        const std::vector<mesh::TetFace>& faces_;
        double size_ = 0.0;
    };

} // namespace

RandomStroke random_stroke(const Body& body, const mesh::CutSession& session, const State& now,
    const RandomStroke& last, std::mt19937_64& random)
{
    Maker make(body, session, now, random);
    const double edge = make.edge(), size = make.size();
    const double length = make.uniform(0.5, 8.0) * edge;
    const double depth = make.uniform(0.3, 5.0) * edge;
    const std::size_t kind = make.index(16);
    const std::size_t more = make.index(1000); // points of a line, beyond the least
    const double bend = make.uniform(-1.0, 1.0);
    switch (kind) {
    case 0:
    case 1:
        return { "straight", make.from_surface(length, depth, 2, 0.0), false };
    case 2:
        return { "kinked", make.from_surface(length, depth, 3 + static_cast<int>(more % 2), bend), false };
    case 3:
        return { "curved", make.from_surface(1.5 * length, depth, 8 + static_cast<int>(more % 10), 0.2 * bend), false };
    case 4: {
        RandomStroke stroke { "directions", make.from_surface(length, depth, 4, 0.3 * bend), false };
        mesh::Blade& blade = stroke.blade;
        const double share = make.uniform(0.0, 0.4);
        const Vec3 lean = share * make.unit_vector(), in = blade.directions.front();
        blade.directions.clear();
        for (std::size_t i = 0; i < blade.line.size(); ++i)
            blade.directions.push_back((in + (static_cast<double>(i) / 3.0 - 0.5) * lean).normalized());
        return stroke;
    }
    case 5:
        return { "face", make.in_plane(make.face_of_mesh(false), length, depth), false };
    case 6: {
        auto p = make.face_of_mesh(false);
        p[2] = p[0] + edge * make.unit_vector(); // contains an edge of the mesh
        return { "edge", make.in_plane(p, length, depth), false };
    }
    case 7: {
        auto p = make.face_of_mesh(false);
        p[1] = p[0] + edge * make.unit_vector();
        p[2] = p[0] + edge * make.unit_vector(); // contains a vertex
        return { "vertex", make.in_plane(p, length, depth), false };
    }
    case 8:
        return { "interface", make.in_plane(make.face_of_mesh(true), length, depth), false };
    case 9:
        return { "on wound", make.at_wound(false), false };
    case 10:
        return { "across wound", make.at_wound(true), false };
    case 11:
        return { "severing", make.from_surface(2.0 * size, 2.0 * size, 2 + static_cast<int>(more % 2), 0.3 * bend),
            false };
    case 12:
        return { "tiny",
            make.from_surface(
                (0.02 + 0.68 * std::abs(bend)) * edge, (0.02 + 0.68e-3 * static_cast<double>(more)) * edge, 2, 0.0),
            false };
    case 13:
        return { "long", make.from_surface(2.0 * size, depth, 2 + static_cast<int>(more % 4), 0.2 * bend), false };
    case 14: {
        if (last.blade.line.empty())
            return { "through", make.from_surface(length, 2.0 * size, 2, 0.0), false };
        RandomStroke again { "again", last.blade, false };
        if (make.chance(0.5))
            again.blade.depth_mm *= make.uniform(1.05, 2.0);
        if (make.chance(0.3))
            std::reverse(again.blade.line.begin(), again.blade.line.end());
        if (again.blade.directions.size() > 1)
            again.blade.directions.resize(1);
        return again;
    }
    default:
        return { "freehand", make.from_surface(1.5 * length, depth, 6 + static_cast<int>(more % 6), 0.3 * bend), true };
    }
}

} // namespace retractor::fuzz
