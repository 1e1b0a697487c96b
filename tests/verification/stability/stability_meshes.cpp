// Extreme meshes: elements of nearly no volume, angles below one degree.

#include "tests/verification/stability/stability_meshes.h"
#include "tests/verification/stability/stability_families.h"

#include "fem/statics/opening.h"
#include "tests/verification/framework/incision.h"
#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/stability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace retractor::verification {

namespace {

    constexpr double kRatio = 1e-9; // ratio of an element's volume to its neighbours' volume

    Vec3 slanted_field(const Vec3& p)
    {
        Mat3 gradient;
        gradient << 0.01, 0.02, -0.03, 0.005, -0.01, 0.015, 0.02, 0.0, 0.03;
        return gradient * p + Vec3(0.1, 0.2, 0.3);
    }

    std::vector<VerificationLaw> laws()
    {
        const fem::Lame l = linear_law(1.0, 0.3).lame;
        return { linear_law(1.0, 0.3), { "corotational", fem::Elasticity::corotational, l, {}, {} },
            hyperelastic_law("neo-Hookean", fem::NeoHookean { l.mu, l.lambda }) };
    }

    /// @param bound largest error over the largest displacement that passes.
    void patch_test(StabilityRow& row, const mesh::TetMesh& mesh, VerificationElement element,
        const VerificationLaw& law, double bound, const Job& job)
    {
        const Held held = hold_boundary(mesh, slanted_field);
        fem::ElasticBody body = make_body(mesh, element, law);
        const VerificationSolve solve = solve_problem(body, held.prescribed, held.target, { .tolerance = 1e-9 }, job);
        row.residual = residual_of(solve.equilibrium, held.prescribed);
        set_condition(row, body.stiffness(solve.equilibrium.displacement, 0.0), held.prescribed);
        if (solve.equilibrium.status != fem::EquilibriumStatus::converged)
            return refuse(row, "not converged at " + std::to_string(100.0 * solve.equilibrium.load) + " %");
        const Eigen::VectorXd exact = nodal_values(mesh, slanted_field);
        row.quantity = "linear field, largest error over largest value";
        row.error = (solve.equilibrium.displacement - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff();
        row.bound = bound;
    }

    std::string model(VerificationElement element, const VerificationLaw& law)
    {
        return element_name(element) + ", " + law.name;
    }

    mesh::TetMesh mesh_for(const mesh::TetMesh& mesh, VerificationElement element)
    {
        return nodes_per_tet(element) == 10 ? mesh::with_midpoints(mesh) : mesh;
    }

    /// A box with one layer of a billionth of the others' thickness.
    mesh::TetMesh box_with_thin_layer()
    {
        return mapped_box(4, 4, 4, 4, [](const Vec3& p) -> Vec3 {
            return { p.x(), p.y(), p.z() < 1.5 ? p.z() : p.z() - 1.0 + kRatio };
        });
    }

    std::string angle_text(const mesh::CutReport& report)
    {
        std::array<char, 96> text {};
        (void)std::snprintf(text.data(), text.size(),
            "smallest dihedral angle %.2g degrees, smallest volume %.1e of the mean", report.worst_dihedral_deg,
            report.smallest_volume_ratio);
        return text.data();
    }

    /// A cut that runs 0.03 mm beside a plane of the grid. Without moving vertices the cut leaves slivers.
    mesh::Blade grazing_blade(const IncisedBlock& block)
    {
        mesh::Blade blade = incision_blade(block);
        constexpr double kOff = 0.03; // mm
        for (Vec3& p : blade.line)
            p.y() += kOff;
        return blade;
    }

    void stretch_sharp(StabilityRow& row, const Incision& cut, double bound, const Job& job)
    {
        std::vector<VertexId> lips;
        for (const mesh::LipFace& lip : cut.lips)
            for (const VertexId v : mesh::face_vertices(cut.mesh, lip.face))
                lips.push_back(v);
        row.reason = angle_text(cut.report);
        stretch_along(row, cut.mesh, lips, 0, bound, job);
        if (!(cut.report.worst_dihedral_deg < 1.0))
            throw PromiseNotKept("the case needs an angle below a degree; " + angle_text(cut.report));
    }

    /// Opens the wound and compares the hook forces with those of the same cut with good angles.
    void open_sharp(
        StabilityRow& row, const IncisedBlock& block, const Incision& sharp, fem::Elasticity elasticity, const Job& job)
    {
        const fem::Material tissue { "tissue", 0.04, 0.45, 1e-9, "verification" };
        const Vec3 pull(0.0, 4.0, 1.0);
        const auto opened = [&](const fem::ElasticProblem& problem) {
            fem::Opening opening(
                problem.mesh, problem.material_of_label, problem.supports, { .elasticity = elasticity });
            return opening.open(problem.hooks, job);
        };
        const Incision good = incise(uncut_block(block), grazing_blade(block));
        const fem::ElasticProblem problem = hooked_open(block, sharp, tissue, pull);
        const fem::OpeningResult result = opened(problem);
        const double measured = result.hook_forces_N[1].norm();
        const double expected = opened(hooked_open(block, good, tissue, pull)).hook_forces_N[1].norm();
        set_condition(row, problem, elasticity, result.displacement);
        row.residual = result.residual;
        row.quantity = "hook force against the same cut with its slivers opened";
        row.error = std::abs(measured / expected - 1.0);
        row.bound = 0.05; // the two cuts differ by the width of a sliver and by the stiffness of the elements
        row.reason = angle_text(sharp.report);
        if (result.status == fem::OpeningStatus::inverted) // the status says so; the force is right all the same
            row.reason += "; " + std::to_string(result.inverted_elements) + " elements inside out";
        else if (result.status != fem::OpeningStatus::converged)
            refuse(row, result.message);
    }

} // namespace

void stretch_along(StabilityRow& row, const mesh::TetMesh& mesh, const std::vector<VertexId>& lip_vertices, int axis,
    double bound, const Job& job)
{
    constexpr double kNu = 0.3, kStrain = 0.01;
    const auto field = [&](const Vec3& p) -> Vec3 {
        Vec3 u = -kNu * kStrain * p;
        u[axis] = kStrain * p[axis];
        return u;
    };
    Held held = hold_boundary(mesh, field);
    const Eigen::VectorXd along = mesh.vertices.col(axis);
    const double tiny = 1e-9 * (along.maxCoeff() - along.minCoeff());
    for (const VertexId v : lip_vertices) {
        const bool pulled = along[v] < along.minCoeff() + tiny || along[v] > along.maxCoeff() - tiny;
        // at an end where the wound opens, nodes are pulled along the axis and slide across
        for (int a = 0; a < 3; ++a)
            if (a != axis || !pulled)
                held.prescribed[3 * static_cast<std::size_t>(v) + static_cast<std::size_t>(a)] = 0;
    }
    fem::ElasticBody body = make_body(mesh, VerificationElement::p1, linear_law(1.0, kNu));
    const VerificationSolve solve = solve_problem(body, held.prescribed, held.target, { .tolerance = 1e-9 }, job);
    row.residual = residual_of(solve.equilibrium, held.prescribed);
    const Eigen::VectorXd exact = nodal_values(mesh, field);
    row.quantity = "linear field, largest error over largest value";
    row.error = (solve.equilibrium.displacement - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff();
    row.bound = bound;
    set_condition(row, body.last_stiffness(), held.prescribed);
}

StabilityCase tiny_element_case()
{
    return { "element of volume 1e-9", "patch test: round-off times what the element's shape costs",
        [](const Job& job) {
            std::vector<StabilityRow> rows;
            // Round-off in the gradients of such a flat element is 1e-16 / 1e-9.
            constexpr double kBound = 1e-6;
            for (const VerificationElement element :
                { VerificationElement::p1, VerificationElement::locking_free, VerificationElement::p2 })
                for (const VerificationLaw& law : laws())
                    rows.push_back(attempt("flat element, volume 1e-9", model(element, law), [&](StabilityRow& row) {
                        patch_test(row, mesh_for(box_with_sliver(kRatio), element), element, law, kBound, job);
                    }));
            for (const VerificationElement element : { VerificationElement::p1, VerificationElement::p2 })
                rows.push_back(attempt("layer 1e-9 as thick", model(element, laws().front()), [&](StabilityRow& row) {
                    patch_test(row, mesh_for(box_with_thin_layer(), element), element, laws().front(), kBound, job);
                }));
            return rows;
        } };
}

StabilityCase sharp_angles_case()
{
    return { "angles under a degree", "a cut that grazes the grid, nothing moved out of its way", [](const Job& job) {
                std::vector<StabilityRow> rows;
                const IncisedBlock block;
                mesh::CutOptions raw;
                raw.snap = 0.0;
                const Incision sharp = incise(uncut_block(block), grazing_blade(block), raw);
                constexpr double kBound = 1e-10; // round-off times the aspect ratio of the slivers
                rows.push_back(attempt("pulled along a grazing cut", "P1, linear",
                    [&](StabilityRow& row) { stretch_sharp(row, sharp, kBound, job); }));
                for (const auto& [name, elasticity] : { std::pair { "P1, linear", fem::Elasticity::linear },
                         std::pair { "P1, corotational", fem::Elasticity::corotational } })
                    rows.push_back(attempt("opened after a grazing cut", name,
                        [&, e = elasticity](StabilityRow& row) { open_sharp(row, block, sharp, e, job); }));
                return rows;
            } };
}

} // namespace retractor::verification
