// Validation problem 5: a cut under tension gapes. Finite elements on the cut mesh are compared with the closed form,
// and so is the solution that follows the knife (OnlineOpening).

#include "tests/verification/analytic/analytic_problems.h"

#include "fem/interactive/online_opening.h"
#include "fem/model/pre_strain.h"
#include "mesh/base/error.h"
#include "mesh/base/job.h"
#include "mesh/cutting/cut_session.h"
#include "tests/verification/framework/element_stress.h"
#include "tests/verification/framework/meshes.h"
#include "tests/verification/framework/tension.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::verification {

namespace {

    constexpr double kSkinModulus = 0.2; // skin, MPa; the gape does not depend on the modulus
    constexpr double kSkinRatio = 0.25;
    constexpr double kStrain = 0.04, kAlongCut = 0.01; // the second strain where the two strains differ
    constexpr double kOnMiddle = 1e-9; // mm

    struct Tension {
        fem::PreStrainKind kind;
        const char* name;
        double strain = kStrain, poissons_ratio = kSkinRatio;
        fem::PreStrain pre_strain() const { return { kind, strain, Vec3::UnitY(), Vec3::UnitZ(), kAlongCut }; }
        double stress() const
        {
            const Mat3 all = fem::pre_stress(pre_strain(), skin());
            return all(1, 1);
        }
        fem::Material skin() const { return { "skin", kSkinModulus, poissons_ratio, 1.1e-9, "reference" }; }
    };
    constexpr Tension kTensions[] = { { fem::PreStrainKind::uniaxial_stress, "incision gape, pulled across" },
        { fem::PreStrainKind::held_width, "incision gape, width held" },
        { fem::PreStrainKind::equibiaxial, "incision gape, both ways" },
        { fem::PreStrainKind::biaxial, "incision gape, 4 % across it and 1 % along" } };
    /// Strain for nonlinear laws. The closed form holds for small strain; at this strain nonlinear laws follow the
    /// closed form up to squares of the strain.
    constexpr double kSmallStrain = 1e-4;
    constexpr Tension kSmallTension { fem::PreStrainKind::uniaxial_stress, "incision gape, 0.01 % across it",
        kSmallStrain };

    /// Incompressible skin: the gape is the same.
    constexpr Tension kIncompressible { fem::PreStrainKind::uniaxial_stress, "incision gape, pulled across, nu 0.49",
        kStrain, 0.49 };

    VerificationLaw skin_law(const Tension& tension, fem::Elasticity model)
    {
        VerificationLaw law = linear_law(kSkinModulus, tension.poissons_ratio);
        if (model == fem::Elasticity::hyperelastic)
            return hyperelastic_law("neo-Hookean", fem::NeoHookean { law.lame.mu, law.lame.lambda });
        law.model = model;
        law.name = model == fem::Elasticity::linear ? "linear" : "corotational";
        return law;
    }

    struct TenseSheet {
        SheetProblem problem;
        Tension tension;
        std::vector<fem::Material> materials = std::vector<fem::Material>(2, tension.skin());
        mesh::TetMesh uncut = sheet_mesh(problem);
        std::vector<Mat3> stresses
            = stress_of_elements(uncut, materials, std::vector<fem::PreStrain>(2, tension.pre_strain()));
        mesh::CutSession session { uncut };

        mesh::CutResult cut()
        {
            mesh::CutResult result = session.cut(sheet_blade(problem));
            if (result.status != mesh::CutStatus::done)
                throw SolverError("the sheet was not cut: " + result.message);
            return result;
        }
    };

    /// @param mesh the solved mesh: cut, with the vertices that the cut doubled.
    VerificationRow row_of(const TenseSheet& sheet, const std::string& element, const mesh::TetMesh& mesh)
    {
        VerificationRow row;
        row.problem = sheet.tension.name;
        row.element = element;
        row.law = "linear";
        row.nodes = mesh.vertex_count();
        row.tets = mesh.tet_count();
        row.size = 1.0 / sheet.problem.around;
        return row;
    }

    void compare_gape(VerificationRow& row, const TenseSheet& sheet, double gape)
    {
        compare(row, "gape in the middle, mm", gape,
            sheet_gape(sheet.tension.kind, sheet.tension.strain, sheet.problem.cut_length, sheet.tension.poissons_ratio,
                kAlongCut));
    }

    /// The rim moves as the infinite sheet does there.
    Points rim_displacement(const TenseSheet& sheet, const mesh::TetMesh& mesh, const std::vector<VertexId>& rim)
    {
        Points u = Points::Zero(mesh.vertices.rows(), 3);
        for (const VertexId v : rim)
            u.row(v) = sheet_displacement(sheet.problem.cut_length, sheet.tension.stress(), kSkinModulus,
                sheet.tension.poissons_ratio, mesh.vertices.row(v).transpose())
                           .transpose();
        return u;
    }

    /// As release_wound(), also for elements with averaged strain and for nonlinear laws.
    ReleasedWound released(VerificationElement element, const VerificationLaw& law, const fem::Material& skin,
        const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& lips, const std::vector<Mat3>& stresses,
        const std::vector<VertexId>& rim, const Points& rim_displacement, const Job& job)
    {
        if (law.model == fem::Elasticity::linear
            && (element == VerificationElement::p1 || element == VerificationElement::p2))
            return release_wound(
                mesh, lips, stresses, std::vector<fem::Material>(2, skin), { .fixed = rim }, rim_displacement, job);
        Held held = hold_nothing(mesh);
        for (const VertexId v : rim)
            for (int axis = 0; axis < 3; ++axis)
                hold(held, v, axis, rim_displacement(v, axis));
        fem::ElasticBody body = make_body(mesh, element, law);
        body.set_loads({ fem::traction_loads(mesh, fem::released_tractions(mesh, lips, stresses)), {} });
        // The forces of such small strains are differences of large forces, so round-off is larger.
        const double tolerance = law.model == fem::Elasticity::linear ? 1e-9 : 1e-7;
        const VerificationSolve solve
            = solve_problem(body, held.prescribed, held.target, { .load_steps = 1, .tolerance = tolerance }, job);
        if (solve.equilibrium.status != fem::EquilibriumStatus::converged)
            throw SolverError("the gaping sheet was not solved: " + solve.equilibrium.message);
        ReleasedWound wound;
        wound.displacement = Eigen::Map<const Points>(solve.equilibrium.displacement.data(), mesh.vertices.rows(), 3);
        wound.relative_residual = solve.equilibrium.residual;
        wound.solve_seconds = solve.seconds;
        return wound;
    }

    VerificationRow on_the_cut_mesh(const Tension& tension, VerificationElement element, int around, const Job& job,
        fem::Elasticity model = fem::Elasticity::linear)
    {
        const VerificationLaw law = skin_law(tension, model);
        TenseSheet sheet { .problem = { .around = around }, .tension = tension };
        const mesh::CutResult cut = sheet.cut();
        mesh::SlotMap map;
        mesh::TetMesh mesh = sheet.session.compact_mesh(&map);
        if (nodes_per_tet(element) == 10)
            mesh = mesh::with_midpoints(mesh);
        std::vector<mesh::TetFace> lips;
        for (const mesh::LipFace& lip : sheet.session.lips())
            lips.push_back({ map.compact_tet[static_cast<std::size_t>(lip.face.tet)], lip.face.corner });
        std::vector<Mat3> carried;
        for (const TetId slot : map.tet_slot)
            carried.push_back(sheet.stresses[static_cast<std::size_t>(sheet.session.origin(slot))]);
        const std::vector<VertexId> rim = sheet_rim(sheet.problem, mesh);
        const ReleasedWound wound
            = released(element, law, tension.skin(), mesh, lips, carried, rim, rim_displacement(sheet, mesh, rim), job);
        double gape = 0.0;
        int count = 0;
        for (const auto& born : cut.delta.vertices_born)
            if (born.origin == mesh::MeshDelta::Origin::copy && std::abs(born.position.x()) < kOnMiddle) {
                const auto at = [&](VertexId id) { return map.compact_vertex[static_cast<std::size_t>(id)]; };
                gape += std::abs(wound.displacement(at(born.id), 1) - wound.displacement(at(born.a), 1));
                ++count;
            }
        VerificationRow row = row_of(sheet, element_name(element), mesh);
        row.law = law.name;
        compare_gape(row, sheet, gape / std::max(count, 1));
        row.residual = wound.relative_residual;
        row.seconds = wound.assemble_seconds + wound.factor_seconds + wound.solve_seconds;
        return row;
    }

    /// The path of the knife.
    std::vector<VertexId> cut_line(const TenseSheet& sheet)
    {
        std::vector<VertexId> line;
        const mesh::TetMesh& mesh = sheet.uncut;
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertex_count()); ++v)
            if (std::abs(mesh.vertices(v, 1)) < kOnMiddle
                && std::abs(mesh.vertices(v, 0)) < 0.5 * sheet.problem.cut_length + kOnMiddle)
                line.push_back(v);
        return line;
    }

    /// The rim is fixed at 15 half lengths of the cut, with an influence of order (1/15)^2. The time runs from the
    /// cut to the whole field; the body was factored before.
    VerificationRow while_cutting(const Tension& tension, int around)
    {
        TenseSheet sheet { .problem = { .radius = 600.0, .around = around }, .tension = tension };
        fem::OnlineOptions options;
        options.stress_of_element = sheet.stresses;
        fem::OnlineOpening opening(sheet.session, sheet.materials, { .fixed = sheet_rim(sheet.problem, sheet.uncut) },
            cut_line(sheet), options);
        const mesh::CutResult cut = sheet.cut();
        const Stopwatch watch;
        opening.follow(cut.delta, sheet.session.lips());
        fem::OnlineAnswer answer = opening.answer();
        if (answer.status == fem::OnlineStatus::solved)
            opening.complete(answer);
        VerificationRow row = row_of(sheet, "P1, while cut", sheet.session.compact_mesh());
        row.seconds = watch.seconds();
        if (answer.status != fem::OnlineStatus::solved)
            throw SolverError("the cut was not followed: " + answer.message);
        double gape = 0.0;
        int count = 0;
        for (const auto& born : cut.delta.vertices_born)
            if (born.origin == mesh::MeshDelta::Origin::copy && std::abs(born.position.x()) < kOnMiddle) {
                gape += std::abs(answer.displacement[3 * born.id + 1] - answer.displacement[3 * born.a + 1]);
                ++count;
            }
        compare_gape(row, sheet, gape / std::max(count, 1));
        row.residual = answer.residual;
        return row;
    }

} // namespace

VerificationProblem gape_problem()
{
    return { "incision gape",
        "a through cut of 80 mm in a large sheet under 4 % tension, plane stress: 2 e L, over 1 - nu^2 with the width "
        "held, over 1 - nu when pulled both ways, 2 (e + nu a) L over 1 - nu^2 with another strain a along it; the "
        "sheet is one cell thick, which opens it more than a thin one: "
        "ten-node elements see that, of order 1",
        [](const VerificationOptions& options, const Job& job) {
            // effect of the sheet's thickness; cells of ten-node elements are twice as large
            constexpr double kFour = 0.01, kTen = 0.03;
            constexpr double kRim = 0.02; // effect of the rim, which is fixed where the sheet is solved while it is cut
            std::vector<int> around { 32, 64, 96 };
            if (options.fine)
                around.push_back(128);
            std::vector<VerificationRow> rows;
            // Only the stress across the lips loads them. All tensions are therefore multiples of the first, and P1
            // alone is enough for them.
            for (const Tension& tension : kTensions) {
                const bool first = tension.kind == fem::PreStrainKind::uniaxial_stress;
                std::vector<VerificationRow> p1, p2, online;
                for (const int n : around) {
                    if (job.cancelled())
                        break;
                    p1.push_back(on_the_cut_mesh(tension, VerificationElement::p1, n, job));
                    if (!first)
                        continue;
                    p2.push_back(on_the_cut_mesh(tension, VerificationElement::p2, n / 2, job));
                    online.push_back(while_cutting(tension, n));
                }
                append_series(rows, p1, 2.0, kFour);
                append_series(rows, p2, 1.0, kTen);
                append_series(rows, online, 1.0, kRim);
                if (first)
                    for (const VerificationElement element :
                        { VerificationElement::locking_free, VerificationElement::nodal }) {
                        std::vector<VerificationRow> series;
                        for (const int n : around)
                            if (!job.cancelled())
                                series.push_back(on_the_cut_mesh(tension, element, n, job));
                        append_series(rows, series, 1.0, kTen);
                    }
            }
            std::vector<VerificationRow> incompressible;
            for (const int n : around)
                if (!job.cancelled())
                    incompressible.push_back(
                        on_the_cut_mesh(kIncompressible, VerificationElement::locking_free, n, job));
            append_series(rows, incompressible, 1.0, kTen);
            for (const fem::Elasticity model : { fem::Elasticity::corotational, fem::Elasticity::hyperelastic }) {
                std::vector<VerificationRow> series;
                for (const int n : around)
                    if (!job.cancelled())
                        series.push_back(on_the_cut_mesh(kSmallTension, VerificationElement::p1, n, job, model));
                append_series(rows, series, 2.0, kFour);
            }
            return rows;
        },
        "tensions after the first by P1 alone: the same linear problem, scaled. Laws that are not linear by P1 at a "
        "strain so small that the closed form holds; of these neo-Hookean alone, as all isotropic ones are alike "
        "there. Fibres make the sheet anisotropic, which the closed form is not" };
}

} // namespace retractor::verification
