#include "fem/statics/local_problem.h"

#include "fem/statics/opening.h"
#include "tests/support/reference_problems.h"
#include "tests/verification/framework/incision.h"

#include <gtest/gtest.h>

#include <limits>

namespace retractor::fem {
namespace local_problem_test {

    using test_support::material;
    using test_support::message_of;

    struct Wound {
        verification::IncisedBlock block;
        verification::Incision incision
            = verification::incise(verification::uncut_block(block), verification::incision_blade(block));
        ElasticProblem problem
            = verification::hooked_open(block, incision, test_support::material(0.04, 0.45), Vec3(0.0, 3.0, 1.0));
        Points lips() const
        {
            std::vector<VertexId> vertices;
            for (const mesh::LipFace& lip : incision.lips)
                for (const VertexId v : mesh::face_vertices(incision.mesh, lip.face))
                    vertices.push_back(v);
            return incision.mesh.vertices(vertices, Eigen::all);
        }
    };

    OpeningResult open(const ElasticProblem& problem)
    {
        Opening opening(
            problem.mesh, problem.material_of_label, problem.supports, { .elasticity = Elasticity::linear });
        return opening.open(problem.hooks);
    }

    TEST(LocalProblem, OfEverythingIsTheWhole)
    {
        const Wound wound;
        const LocalProblem local = local_problem(wound.problem, wound.lips(), 1000.0);
        EXPECT_EQ(local.rim_vertices, 0U);
        ASSERT_EQ(local.problem.mesh.vertices, wound.problem.mesh.vertices);
        EXPECT_EQ(open(local.problem).displacement, open(wound.problem).displacement);
    }

    TEST(LocalProblem, ComesNearerToTheWholeAsItGrowsAndIsNeverSofter)
    {
        const Wound wound;
        const double whole = open(wound.problem).hook_forces_N[1].norm();
        double before = std::numeric_limits<double>::infinity();
        for (const double distance : { 6.0, 11.0, 16.0 }) {
            const LocalProblem local = local_problem(wound.problem, wound.lips(), distance);
            EXPECT_GT(local.rim_vertices, 0U);
            const OpeningResult part = open(local.problem);
            const double force = part.hook_forces_N[1].norm();
            EXPECT_GT(force, whole) << distance;
            EXPECT_LT(force, before) << distance;
            before = force;
            for (std::size_t v = 0; v < local.vertex_of.size(); ++v)
                EXPECT_EQ(local.problem.mesh.vertices.row(static_cast<Eigen::Index>(v)),
                    wound.problem.mesh.vertices.row(local.vertex_of[v]));
        }
    }

    TEST(LocalProblem, RefusesHooksThatReachBeyondItAndDistancesThatAreNone)
    {
        const Wound wound;
        ElasticProblem far = wound.problem;
        far.hooks[0].nodes.push_back(far.supports.fixed.front());
        EXPECT_NE(test_support::message_of([&] { (void)local_problem(far, wound.lips(), 6.0); }).find("hook 'right'"),
            std::string::npos);
        EXPECT_NE(test_support::message_of([&] { (void)local_problem(wound.problem, wound.lips(), 0.0); }),
            "nothing was thrown");
        EXPECT_NE(test_support::message_of([&] { (void)local_problem(wound.problem, Points(0, 3), 5.0); }),
            "nothing was thrown");
    }

} // namespace local_problem_test
} // namespace retractor::fem
