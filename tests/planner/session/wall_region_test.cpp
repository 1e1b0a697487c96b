#include "planner/session/wall_region.h"

#include "tests/planner/session/layered_wall.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace retractor::planner {
namespace wall_region_test {

    // Positions of some 100 mm, a few operations each.
    constexpr double kRoundingMm = 1e-10;
    // The border is interpolated along edges of 5 mm (diagonals 7.1): the sag of a circle of 28 mm over one, 7.1^2 / (8
    // * 28).
    constexpr double kSagMm = 0.23;

    /// A planned incision of 20 mm in the middle of the slab, meshed within 40 mm.
    WallRegion small_region()
    {
        return { .corridor = { { 60.0, 0.0, 50.0 }, { 60.0, 0.0, 70.0 } }, .meshed_mm = 40.0 };
    }

    double from_incision(const Vec3& p) { return (p - Vec3(60.0, 0.0, std::clamp(p.z(), 50.0, 70.0))).norm(); }

    TEST(WallRegion, KeepsTheKnifeOffTheRim)
    {
        const WallRegion region = small_region();
        EXPECT_TRUE(region.can_cut({ 60.0, 0.0, 60.0 }));
        EXPECT_NEAR(region.rim_distance({ 90.0, 0.0, 60.0 }), 10.0, kRoundingMm);
        EXPECT_TRUE(region.can_cut({ 87.9, 0.0, 60.0 }));
        EXPECT_FALSE(region.can_cut({ 88.1, 0.0, 60.0 }));
        EXPECT_FALSE(region.can_cut({ 130.0, 0.0, 60.0 }));
        EXPECT_TRUE(WallRegion {}.can_cut({ 1e6, 0.0, 0.0 })) << "all of the wall is meshed";
        EXPECT_EQ(WallRegion {}.rim_distance({ 1e6, 0.0, 0.0 }), std::numeric_limits<double>::infinity());
    }

    TEST(WallRegion, ItsOutlineIsALineOnTheSkinWhereTheKnifeMayStillCut)
    {
        const SurgerySetup setup = layered_wall();
        const std::vector<EdgePlace> places = region_outline(setup.wall, small_region(), setup.labels, setup.outward);
        SurgerySession live_session(layered_wall());
        const std::vector<Vec3> shown = shown_places(places, *live_session.picture());
        ASSERT_GT(shown.size(), 20U);
        ASSERT_EQ(shown.size() % 2, 0U);
        double length = 0.0;
        for (std::size_t i = 0; i < shown.size(); i += 2) {
            length += (shown[i] - shown[i + 1]).norm();
            EXPECT_NEAR(shown[i].y(), 0.0, kRoundingMm) << "on the skin";
            EXPECT_NEAR(from_incision(shown[i]), 28.0, kSagMm);
        }
        EXPECT_NEAR(length, 2.0 * 20.0 + 2.0 * M_PI * 28.0, 0.01 * length) << "all round";
        EXPECT_TRUE(region_outline(setup.wall, {}, setup.labels, setup.outward).empty());
    }

    TEST(BeyondSurface, ReplacesTheSoftTissueOfTheRimButNoLip)
    {
        SurgerySetup setup = layered_wall();
        const WallRegion region = small_region();
        const BeyondSurface beyond(std::make_shared<const TriMesh>(), setup.wall, region);
        SurgerySession live_session(layered_wall());
        WallSurface surface = *live_session.picture()->surface;
        const std::vector<std::uint8_t> replaced = beyond.replaces(surface, setup.labels);
        ASSERT_EQ(replaced.size(), surface.triangles.size());
        std::size_t count = 0;
        for (std::size_t t = 0; t < replaced.size(); ++t) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const VertexId v : surface.triangles[t])
                nearest = std::min(nearest, from_incision(surface.rest.row(v).transpose()));
            const mesh::LabelInfo* const info = mesh::find_label(setup.labels, surface.labels[t]);
            const bool soft = info == nullptr || (info->material != "bone" && info->material != "cartilage");
            EXPECT_EQ(replaced[t] != 0, soft && nearest > region.meshed_mm - kFittedRimMm) << "triangle " << t;
            count += replaced[t];
        }
        EXPECT_GT(count, 0U);
        surface.is_lip.assign(surface.is_lip.size(), 1);
        const std::vector<std::uint8_t> of_lips = beyond.replaces(surface, setup.labels);
        EXPECT_EQ(std::count(of_lips.begin(), of_lips.end(), 1), 0);
    }

    TEST(BeyondSurface, GoesAlongWithTheRimAndRestsFarAway)
    {
        SurgerySetup setup = layered_wall();
        const WallRegion region { .corridor = { { 60.0, 0.0, 0.0 }, { 60.0, 0.0, 120.0 } }, .meshed_mm = 60.0 };
        auto sheet = std::make_shared<TriMesh>();
        sheet->vertices.resize(4, 3);
        sheet->vertices << 121.0, 0.0, 60.0, 140.0, 0.0, 60.0, 170.0, 0.0, 60.0, 140.0, 0.0, 80.0;
        sheet->triangles = { { 0, 1, 3 }, { 1, 2, 3 } };
        sheet->labels = { kSkin, kSkin };
        const BeyondSurface beyond(sheet, setup.wall, region);
        SurgerySession live_session(std::move(setup));
        WallPicture picture = *live_session.picture();
        EXPECT_EQ(beyond.shown(picture), sheet->vertices) << "the wall lies at rest";
        picture.shown.rowwise() += Eigen::RowVector3d(3.0, 0.0, 4.0);
        const Points moved = beyond.shown(picture) - sheet->vertices;
        EXPECT_NEAR(moved.row(0).norm(), 5.0, 0.02) << "1 mm from the rim: 1 - 3 / 40^2 of it";
        EXPECT_NEAR(moved.row(1).norm(), 2.5, 0.01) << "20 mm from it: half";
        EXPECT_EQ(moved.row(2).norm(), 0.0);
    }

    /// A cut far from the outline, which takes the ids of vertices that are gone.
    void cut_elsewhere(SurgerySession& live_session)
    {
        const auto at = [&](double x) { return *touch(*live_session.picture(), ray_down(x, 105.0)); };
        ASSERT_TRUE(live_session.begin_stroke(at(10.0), {}).done);
        for (double x = 15.0; x <= 45.0; x += 5.0)
            ASSERT_TRUE(live_session.draw_to(at(x)).done);
        ASSERT_TRUE(live_session.finish_stroke().done);
    }

    TEST(WallRegion, ItsOutlineIsNotDrawnOverTissueThatWasTakenOut)
    {
        const SurgerySetup setup = layered_wall();
        const WallRegion region { .corridor = { { 70.0, 0.0, 50.0 }, { 70.0, 0.0, 70.0 } }, .meshed_mm = 30.0 };
        const std::vector<EdgePlace> places = region_outline(setup.wall, region, setup.labels, setup.outward);
        SurgerySession live_session(setup);
        const std::vector<Vec3> whole = shown_places(places, *live_session.picture());
        const Touch middle = *touch(*live_session.picture(), ray_down(94.0, 60.0));
        ASSERT_TRUE(live_session.take_out(middle, 15.0).done);
        const auto check = [&] {
            const std::vector<Vec3> left = shown_places(places, *live_session.picture());
            EXPECT_GT(left.size(), 20U);
            EXPECT_LT(left.size(), whole.size());
            EXPECT_EQ(left.size() % 2, 0U);
            for (const Vec3& p : left) {
                EXPECT_GT((p - middle.rest).norm(), 15.0 - 2.0 * kSlabEdgeMm) << p.transpose();
                EXPECT_EQ(p.y(), 0.0);
            }
        };
        check();
        cut_elsewhere(live_session);
        check();
        live_session.undo();
        live_session.undo();
        EXPECT_EQ(shown_places(places, *live_session.picture()), whole);
    }

    TEST(BeyondSurface, GoesAlongWithWhatIsLeftOfTheRim)
    {
        SurgerySetup setup = layered_wall();
        setup.held.clear();
        const WallRegion region { .corridor = { { 60.0, 0.0, 0.0 }, { 60.0, 0.0, 120.0 } }, .meshed_mm = 60.0 };
        auto sheet = std::make_shared<TriMesh>();
        sheet->vertices.resize(3, 3);
        sheet->vertices << 121.0, 0.0, 60.0, 140.0, 0.0, 60.0, 170.0, 0.0, 60.0;
        sheet->triangles = { { 0, 1, 2 } };
        sheet->labels = { kSkin };
        const BeyondSurface beyond(sheet, setup.wall, region);
        const Points first = setup.wall.vertices;
        SurgerySession live_session(std::move(setup));
        ASSERT_TRUE(live_session.take_out(*touch(*live_session.picture(), ray_down(119.0, 60.0)), 9.0).done);
        const auto check = [&] {
            WallPicture picture = *live_session.picture();
            picture.shown = picture.surface->rest;
            picture.shown.rowwise() += Eigen::RowVector3d(3.0, 0.0, 4.0);
            std::size_t gone = 0;
            for (Eigen::Index v = 0; v < first.rows(); ++v)
                if (!live_session.session().has_vertex(static_cast<VertexId>(v))
                    || (picture.surface->rest.row(v) - first.row(v)).norm() > kSlabEdgeMm) {
                    picture.shown(v, 0) += 100.0; // of a vertex that is no part of the rim
                    ++gone;
                }
            EXPECT_GT(gone, 0U);
            const Points moved = beyond.shown(picture) - sheet->vertices;
            EXPECT_NEAR(moved.row(0).norm(), 5.0, 0.02);
            EXPECT_NEAR(moved.row(1).norm(), 2.5, 0.01);
        };
        check();
        cut_elsewhere(live_session);
        check();
    }

} // namespace wall_region_test
} // namespace retractor::planner
