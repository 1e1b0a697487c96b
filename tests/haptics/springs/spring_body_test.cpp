#include "haptics/springs/spring_body.h"

#include "haptics/springs/spring_motion.h"

#include "tests/support/test_help.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>

using namespace retractor;
using namespace retractor::haptics;

namespace spring_body_test {

/// A gel on the edges of a block.
SpringBody gel(const mesh::TetMesh& block, double modulus_MPa = 0.02)
{
    return make_spring_organ(block, std::vector<double>(block.tet_count(), modulus_MPa), 1.0e-9, {});
}

TEST(SpringSheet, of25By25HasTheSources3502Springs)
{
    const SpringBody sheet = make_spring_sheet();
    EXPECT_EQ(sheet.springs.size(), 3502U);
    EXPECT_EQ(sheet.mass.size(), 625U);
    std::map<int, int> count; // by squared length
    for (const TissueSpring& spring : sheet.springs)
        ++count[static_cast<int>(std::lround(spring.length * spring.length))];
    EXPECT_EQ(count, (std::map<int, int> { { 1, 1200 }, { 2, 1152 }, { 4, 1150 } }));
    for (const TissueSpring& spring : sheet.springs)
        EXPECT_NEAR(
            (sheet.surface.vertices.row(spring.a) - sheet.surface.vertices.row(spring.b)).norm(), spring.length, 1e-12);
}

TEST(SpringSheet, countsFollowTheFormulaForAnySize)
{
    for (const auto& [columns, rows] : { std::pair { 20, 20 }, { 30, 30 }, { 100, 100 }, { 3, 7 } }) {
        SheetOptions options;
        options.columns = columns;
        options.rows = rows;
        // Structural, shear and bend springs.
        const int springs = columns * (rows - 1) + rows * (columns - 1) + 2 * (columns - 1) * (rows - 1)
            + columns * (rows - 2) + rows * (columns - 2);
        EXPECT_EQ(make_spring_sheet(options).springs.size(), static_cast<std::size_t>(springs));
    }
    EXPECT_EQ(make_spring_sheet({ .columns = 25, .rows = 25 }).springs.size(), 3502u);
}

TEST(SpringSheet, edgesAreHeld)
{
    const SpringBody sheet = make_spring_sheet();
    EXPECT_EQ(std::accumulate(sheet.held.begin(), sheet.held.end(), 0), 96);
}

TEST(SpringOrgan, weighsWhatItsElementsDo)
{
    const mesh::TetMesh block = mesh::kuhn_box(4, 3, 2, 5.0);
    const SpringBody organ = gel(block);
    const double mass = std::accumulate(organ.mass.begin(), organ.mass.end(), 0.0);
    EXPECT_NEAR(mass, 1e-9 * 20.0 * 15.0 * 10.0, 1e-18);
    EXPECT_EQ(organ.touchable.size(), 60U - 6U); // all but the 3 x 2 x 1 inner ones
}

TEST(SpringOrgan, stiffnessGrowsWithYoungsModulus)
{
    const mesh::TetMesh block = mesh::kuhn_box(2, 2, 2, 5.0);
    const SpringBody soft = gel(block), stiff = gel(block, 0.06);
    ASSERT_EQ(soft.springs.size(), stiff.springs.size());
    for (std::size_t s = 0; s < soft.springs.size(); ++s)
        EXPECT_NEAR(stiff.springs[s].stiffness, 3.0 * soft.springs[s].stiffness, 1e-12);
}

TEST(SpringOrgan, SlowedDownToAStepIsStableThere)
{
    SpringBody organ = gel(mesh::kuhn_box(2, 2, 2, 5.0));
    const double stable = SpringMotion(organ, {}).stable_step();
    EXPECT_NEAR(slow_down_to(organ, 10.0 * stable), 100.0, 1e-6);
    EXPECT_GE(SpringMotion(organ, {}).stable_step(), 10.0 * stable);
    EXPECT_EQ(slow_down_to(organ, stable), 1.0); // it is already
}

TEST(SpringBody, refusesWhatCannotMove)
{
    EXPECT_EQ(test_support::message_of([] { make_spring_sheet({ .columns = 2 }); }),
        "a sheet has 3 to 1000 particles a side, got 2");
    EXPECT_EQ(test_support::message_of([] { make_spring_sheet({ .particle_mass = 0.0 }); }),
        "a sheet's particle mass must be positive, got 0.000000");
    EXPECT_EQ(test_support::message_of([] { make_spring_sheet({ .stiffness = -1.0 }); }),
        "a sheet's stiffness must be positive, got -1.000000");
    EXPECT_EQ(test_support::message_of([] { make_spring_sheet({ .spacing = std::nan("") }); }),
        "a sheet's spacing must be positive, got nan");
    SpringBody body = make_spring_sheet();
    body.springs[7].b = 625;
    EXPECT_EQ(test_support::message_of([&] { check_spring_body(body); }), "spring body: spring 7 has wrong ends");
    body = make_spring_sheet();
    body.mass[3] = std::nan("");
    EXPECT_EQ(test_support::message_of([&] { check_spring_body(body); }),
        "spring body: the mass of particle 3 is not positive");
    EXPECT_EQ(test_support::message_of(
                  [] { make_spring_organ(mesh::kuhn_box(1, 1, 1, 1.0), std::vector<double> {}, 1.0e-9, {}); }),
        "one Young's modulus per element is needed");
    EXPECT_EQ(test_support::message_of([] { gel(mesh::with_midpoints(mesh::kuhn_box(1, 1, 1, 1.0))); }),
        "springs lie on the edges of four-node elements, got ten nodes");
}

} // namespace spring_body_test
