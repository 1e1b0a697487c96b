#include "tests/support/half_space.h"

#include "haptics/condensed/contact_solver.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor::test_support {

namespace {

    constexpr double kReach = 1.25; ///< points within this many contact radii may press

    /// Divides each step into `fineness` equal parts.
    std::vector<double> refined(const std::vector<double>& steps, int fineness)
    {
        std::vector<double> places { steps.front() };
        for (std::size_t i = 1; i < steps.size(); ++i)
            for (int k = 1; k <= fineness; ++k)
                places.push_back(steps[i - 1] + (steps[i] - steps[i - 1]) * k / fineness);
        return places;
    }

    /// Maps squares to circles, so that the edge of the contact is a line of the mesh.
    Vec3 rounded(const Vec3& p)
    {
        const double r = std::hypot(p.x(), p.y()), square = std::max(p.x(), p.y());
        return r > 0.0 ? Vec3(p.x() * square / r, p.y() * square / r, p.z()) : p;
    }

} // namespace

HalfSpace::HalfSpace(double radius, double youngs_modulus, double poissons_ratio, int fineness, const Job& job)
{
    if (!(radius > 0.0) || fineness < 1)
        throw InputError("the contact radius and the fineness must be positive", "half-space");
    // In contact radii. The steps are fine at the edge, where the pressure under a flat punch is singular.
    const std::vector<double> across = refined({ 0.0, 0.3, 0.55, 0.75, 0.88, 0.95, 0.985, 1.0, 1.02, 1.07, 1.2, 1.5,
                                                   2.1, 3.2, 5.0, 8.0, 13.0, 21.0, 35.0, 60.0, 100.0 },
        fineness);
    const std::vector<double> down = refined(
        { 0.0, 0.025, 0.08, 0.2, 0.4, 0.75, 1.3, 2.1, 3.4, 5.5, 9.0, 15.0, 25.0, 42.0, 65.0, 100.0 }, fineness);
    const auto n = static_cast<int>(across.size()) - 1, m = static_cast<int>(down.size()) - 1;
    mesh_ = mesh::kuhn_box(n, n, m, 1.0);
    haptics::TouchedBody body;
    body.mesh = &mesh_;
    body.prescribed.assign(3 * mesh_.vertex_count(), 0);
    std::vector<std::uint8_t> fixed(mesh_.vertex_count(), 0), top(mesh_.vertex_count(), 0);
    for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
        auto row = mesh_.vertices.row(static_cast<Eigen::Index>(v));
        const auto i = static_cast<int>(std::lround(row[0])), j = static_cast<int>(std::lround(row[1])),
                   k = static_cast<int>(std::lround(row[2]));
        fixed[v] = i == n || j == n || k == 0;
        top[v] = k == m;
        body.prescribed[3 * v] = i == 0 || fixed[v] != 0;
        body.prescribed[3 * v + 1] = j == 0 || fixed[v] != 0;
        body.prescribed[3 * v + 2] = fixed[v];
        row = radius
            * rounded({ across[static_cast<std::size_t>(i)], across[static_cast<std::size_t>(j)],
                          -down[static_cast<std::size_t>(m - k)] })
                  .transpose();
    }
    mesh::check_mesh(mesh_);
    std::vector<mesh::TetFace> faces;
    for (const mesh::TetFace& face : mesh::boundary_faces(mesh_)) {
        const auto corners = mesh::face_vertices(mesh_, face);
        if (std::all_of(
                corners.begin(), corners.end(), [&](VertexId v) { return top[static_cast<std::size_t>(v)] != 0; }))
            faces.push_back(face);
    }
    // Every vertex is a contact node.
    surface_ = std::make_unique<haptics::TouchSurface>(mesh_, faces, fixed, 1e-3 * radius / fineness);
    const double E = youngs_modulus, nu = poissons_ratio;
    const std::vector<fem::Lame> lame(
        mesh_.tet_count(), fem::Lame { E / (2.0 * (1.0 + nu)), E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) });
    constexpr std::size_t kStore = std::size_t { 512 } << 20U;
    body_ = std::make_unique<haptics::ContactNodeCompliance>(
        body, *surface_, lame, haptics::TouchElement::locking_free, kStore, job);
    for (std::size_t s = 0; s < surface_->contact_nodes().size(); ++s)
        if (surface_->contact_nodes()[s].point.head<2>().norm() <= kReach * radius)
            near_.push_back(static_cast<std::int32_t>(s));
    const haptics::ServoGate nobody;
    body_->fetch(near_, near_.size(), nobody);
}

HalfSpace::~HalfSpace() = default;

HalfSpace::Answer HalfSpace::press(const std::function<double(double)>& depth_at) const
{
    haptics::ContactSolver solver(near_.size());
    constexpr std::size_t kDown = 8; // index of zz in a block
    for (std::size_t a = 0; a < near_.size(); ++a) {
        const haptics::ContactNode& contact_node = surface_->contact_nodes()[static_cast<std::size_t>(near_[a])];
        solver.demand(a) = depth_at(contact_node.point.head<2>().norm());
        solver.pressing(a) = solver.demand(a) > 0.0;
        for (std::size_t b = 0; b <= a; ++b)
            solver.compliance(a, b) = body_->block(near_[a], near_[b])[kDown];
    }
    if (!solver.solve(near_.size()))
        throw SolverError("no contact forces were found", "half-space");
    Answer answer;
    for (std::size_t a = 0; a < near_.size(); ++a) {
        constexpr double kQuarters = 4.0;
        answer.force += kQuarters * solver.force(a);
        if (solver.force(a) > 0.0)
            answer.contact_radius = std::max(answer.contact_radius,
                surface_->contact_nodes()[static_cast<std::size_t>(near_[a])].point.head<2>().norm());
    }
    return answer;
}

double flat_punch_force(double a, double depth, double youngs_modulus, double poissons_ratio)
{
    return 2.0 * a * depth * youngs_modulus / (1.0 - poissons_ratio * poissons_ratio);
}

} // namespace retractor::test_support
