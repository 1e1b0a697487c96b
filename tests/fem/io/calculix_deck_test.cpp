#include "fem/io/calculix_deck.h"

#include "mesh/base/error.h"
#include "tests/support/wounds/hooked_block.h"

#include <gtest/gtest.h>

#include <sstream>

namespace retractor::fem {
namespace calculix_deck_test {

    using namespace test_support;

    std::size_t count(const std::string& text, const std::string& what)
    {
        std::size_t found = 0;
        for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
            ++found;
        return found;
    }

    /// What ccx would print: displacements and, for the held nodes, reactions.
    std::string printed(const ElasticProblem& problem, std::size_t nodes)
    {
        std::ostringstream dat;
        dat << "\n displacements (vx,vy,vz) for set NALL and time  0.1000000E+01\n\n";
        for (std::size_t i = 1; i <= nodes; ++i)
            dat << "  " << i << "  " << 0.5 * static_cast<double>(i) << " -1.000000E-02 2.0E+00\n";
        dat << "\n forces (fx,fy,fz) for set HELD and time  0.1000000E+01\n\n";
        for (const VertexId v : prescribe(problem.mesh, problem.supports, problem.hooks).nodes)
            dat << "  " << v + 1 << "  1.000000E+00 2.000000E+00 " << v << "\n";
        return dat.str();
    }

    TEST(CalculixDeck, HoldsEveryNodeElementMaterialSpringAndHook)
    {
        for (const int nodes_per_tet : { 4, 10 }) {
            const ElasticProblem problem = test_support::hooked_block(2, nodes_per_tet);
            const std::string deck = calculix_deck(problem);
            EXPECT_EQ(count(deck, nodes_per_tet == 4 ? "TYPE=C3D4," : "TYPE=C3D10,"), 2u); // two tissues
            EXPECT_EQ(count(deck, "*ELASTIC"), 2u);
            EXPECT_EQ(count(deck, "*SPRING,"), 6u); // two stiffnesses, three axes
            EXPECT_EQ(count(deck, "*NSET, NSET=HOOK"), 2u);
            const auto lines = static_cast<std::size_t>(std::count(deck.begin(), deck.end(), '\n'));
            EXPECT_GT(lines,
                problem.mesh.vertex_count() + problem.mesh.tet_count() + 3 * problem.supports.bedded.size()
                    + problem.supports.fixed.size());
            EXPECT_EQ(deck, calculix_deck(problem));
        }
    }

    TEST(CalculixDeck, AnEdgeOfAHingeIsATiedNodeOnASpring)
    {
        ElasticProblem problem = test_support::hooked_block(2, 4);
        const std::string without = calculix_deck(problem);
        EXPECT_EQ(count(without, "*EQUATION"), 0u);
        const auto first = problem.mesh.tet(0);
        Hinge hinge { .name = "rib_left_5", .axis = Vec3::UnitZ(), .stiffness = 900.0, .toe = 0.1 };
        for (const VertexId other : { first[1], first[2], first[3] }) {
            const Vec3 along = point_at(problem.mesh.vertices, other) - point_at(problem.mesh.vertices, first[0]);
            if (along.head<2>().norm() > 0.0)
                hinge.edges.push_back({ first[0], other, 0.25 });
        }
        ASSERT_GE(hinge.edges.size(), 2u);
        problem.supports.hinges = { hinge };
        const std::string deck = calculix_deck(problem);
        const std::string node = std::to_string(problem.mesh.vertex_count() + 1);
        EXPECT_EQ(count(deck, "\n" + node + ",1,-1.,"), 1u); // the equation of the first edge
        EXPECT_EQ(count(deck, "*EQUATION\n"), 1u);
        EXPECT_EQ(count(deck, "*SPRING, ELSET=HINGE\n1\n1.\n"), 1u);
        const Vec3 spring = hinge_spring(hinge, hinge.edges[0],
            point_at(problem.mesh.vertices, hinge.edges[0].b) - point_at(problem.mesh.vertices, first[0]));
        const double width
            = (point_at(problem.mesh.vertices, hinge.edges[0].b) - point_at(problem.mesh.vertices, first[0]))
                  .head<2>()
                  .norm();
        EXPECT_NEAR(spring.norm(), std::sqrt(0.25 * 900.0) / width, 1e-12); // share k / width^2, in its square root
    }

    TEST(CalculixDeck, AHookThatTurnsMovesEachOfItsNodes)
    {
        ElasticProblem problem = test_support::hooked_block(2, 4);
        const std::string still = calculix_deck(problem);
        HookPatch& hook = problem.hooks[0];
        hook.rotation << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0; // a quarter turn about z
        hook.pivot = Vec3(15.0, 20.0, 20.0);
        const std::string turned = calculix_deck(problem);
        EXPECT_EQ(count(still, "HOOK1,1,1,"), 1u);
        EXPECT_EQ(count(turned, "HOOK1,1,1,"), 0u);
        const std::string node = "\n" + std::to_string(hook.nodes.front() + 1) + ",3,3,"; // the turn leaves z alone
        EXPECT_EQ(count(turned, node + "0.333"), 1u);
    }

    TEST(CalculixDeck, NumbersFitTheTwentyCharactersThatAreRead)
    {
        ElasticProblem problem = test_support::hooked_block(2, 4);
        problem.hooks[0].displacement = Vec3(-1.2345678901234567e-05, 1.0 / 3.0, -100.0 / 3.0);
        std::istringstream lines(calculix_deck(problem));
        for (std::string line; std::getline(lines, line);) {
            if (line.starts_with("*") || line.starts_with("opened"))
                continue;
            std::istringstream words(line);
            for (std::string word; std::getline(words, word, ',');)
                EXPECT_LE(word.size(), 20u) << line;
        }
    }

    TEST(CalculixDeck, ANameCannotAddLines)
    {
        ElasticProblem problem = test_support::hooked_block(2, 4);
        problem.hooks[0].name = "left\n*STEP";
        EXPECT_EQ(count(calculix_deck(problem), "\n*STEP"), 1u);
    }

    TEST(CalculixDeck, AnAnswerIsReadByNode)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        const CalculixAnswer answer = read_calculix_answer(printed(problem, problem.mesh.vertex_count()), problem);
        for (Eigen::Index v = 0; v < answer.displacement.rows(); ++v)
            EXPECT_EQ(Vec3(answer.displacement.row(v)), Vec3(0.5 * static_cast<double>(v + 1), -0.01, 2.0));
        const VertexId held = problem.hooks[0].nodes.front();
        EXPECT_EQ(Vec3(answer.reaction.row(held)), Vec3(1.0, 2.0, held));
    }

    void expect_refused(const std::string& dat, const ElasticProblem& problem, const std::string& word)
    {
        try {
            (void)read_calculix_answer(dat, problem);
            ADD_FAILURE() << "accepted: " << word;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
            EXPECT_EQ(error.where(), "ccx's .dat file");
        }
    }

    TEST(CalculixDeck, AnAnswerThatIsNotWholeIsRefused)
    {
        const ElasticProblem problem = test_support::hooked_block(2, 4);
        const std::size_t n = problem.mesh.vertex_count();
        const std::string whole = printed(problem, n);
        expect_refused("", problem, "no displacement for node");
        expect_refused(printed(problem, n - 1), problem, "no displacement for node " + std::to_string(n));
        expect_refused(whole.substr(0, whole.find(" forces")), problem, "no reaction for node");
        expect_refused(whole + " 3 1.0 nan 2.0\n", problem, "is not a node of the mesh");
        expect_refused(whole + " 99999 1.0 1.0 2.0\n", problem, "99999");
        expect_refused(whole + " 1 1.0 1.0\n", problem, "three numbers");
    }

    TEST(CalculixDeck, BadProblemsAreRefused)
    {
        ElasticProblem problem = test_support::hooked_block(2, 4);
        problem.supports.bedded[0].stiffness = -1.0;
        EXPECT_THROW((void)calculix_deck(problem), InputError);
        problem = test_support::hooked_block(2, 4);
        problem.supports.bedded.push_back(problem.supports.bedded.front());
        EXPECT_THROW((void)calculix_deck(problem), InputError);
        problem = test_support::hooked_block(2, 4);
        problem.hooks[1].nodes.push_back(problem.hooks[0].nodes.front());
        EXPECT_THROW((void)calculix_deck(problem), InputError);
        problem = test_support::hooked_block(2, 4);
        problem.material_of_label.resize(2);
        EXPECT_THROW((void)calculix_deck(problem), InputError);
    }

} // namespace calculix_deck_test
} // namespace retractor::fem
