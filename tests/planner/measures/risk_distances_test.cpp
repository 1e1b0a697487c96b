#include "planner/measures/risk_distances.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

namespace retractor::planner {
namespace risk_distances_test {

    /// Down from the skin at y = 0 along +y to 20 mm, along z from 10 to 60 mm, at x = 40 mm.
    mesh::Blade straight_blade()
    {
        return {
            .line = { { 40.0, 0.0, 10.0 }, { 40.0, 0.0, 60.0 } }, .directions = { Vec3::UnitY() }, .depth_mm = 20.0
        };
    }

    /// A cube's surface with its voxels as label `id`.
    struct Organs {
        mesh::LabelVolume labels;
        std::map<std::string, std::shared_ptr<const TriMesh>, std::less<>> surfaces;

        Organs()
        {
            labels.grid.size = { 160, 160, 80 };
            labels.grid.spacing.setOnes();
            labels.voxels.assign(160 * 160 * 80, 0);
        }

        void add(const std::string& name, mesh::Role role, const Vec3& low, const Vec3& high)
        {
            const auto id = static_cast<Label>(labels.table.size() + 1);
            labels.table.push_back({ id, name, "organ", role });
            for (int k = 0; k < 80; ++k)
                for (int j = 0; j < 160; ++j)
                    for (int i = 0; i < 160; ++i)
                        if (const Vec3 p(i, j, k);
                            (p.array() >= low.array()).all() && (p.array() <= high.array()).all())
                            labels.voxels[labels.grid.offset(i, j, k)] = id;
            TriMesh cube;
            cube.vertices.resize(8, 3);
            for (int v = 0; v < 8; ++v)
                cube.vertices.row(v) << ((v & 1) != 0 ? high : low).x(), ((v & 2) != 0 ? high : low).y(),
                    ((v & 4) != 0 ? high : low).z();
            surfaces[name] = std::make_shared<const TriMesh>(std::move(cube));
        }

        std::vector<RiskDistance> distances() const
        {
            return risk_distances(
                straight_blade(), labels, [this](std::string_view name) { return surfaces.find(name)->second; });
        }
    };

    constexpr double kRoundOff = 1e-9; // mm

    TEST(RiskDistances, ASawEndsWhereTheWallDoes)
    {
        Organs organs;
        organs.add("heart", mesh::Role::at_risk, Vec3(20.0, 15.0, 20.0), Vec3(60.0, 60.0, 50.0));
        organs.add("aorta", mesh::Role::at_risk, Vec3(38.0, 4.0, 40.0), Vec3(42.0, 8.0, 44.0));
        const auto surface_of = [&](std::string_view name) { return organs.surfaces.find(name)->second; };
        // From the skin at y = 0 to the inner side at y = 15 mm, where the heart begins; a vessel crosses the bone.
        const std::vector<Vec3> skin { { 40.0, 0.0, 10.0 }, { 40.0, 0.0, 60.0 } },
            inner { { 40.0, 15.0, 10.0 }, { 40.0, 15.0, 60.0 } };
        const std::vector<RiskDistance> risks = saw_risk_distances(skin, inner, organs.labels, surface_of);
        ASSERT_EQ(risks.size(), 2U);
        EXPECT_EQ(risks[0].name, "aorta");
        EXPECT_EQ(risks[0].distance_mm, 0.0) << "it is sawn";
        EXPECT_EQ(risks[1].name, "heart");
        EXPECT_NEAR(risks[1].distance_mm, 20.0, kRoundOff) << "to its nearest corner, beside the saw's way";
        const std::vector<RiskDistance> by_knife = organs.distances();
        EXPECT_EQ(by_knife[1].distance_mm, 0.0) << "a knife that goes 20 mm deep cuts it";
        EXPECT_THROW(
            static_cast<void>(saw_risk_distances(skin, { inner.data(), 1 }, organs.labels, surface_of)), InputError);
    }

    TEST(RiskDistances, AreTheShortestToTheBladeAndTheNearestComesFirst)
    {
        Organs organs;
        organs.add("beside", mesh::Role::at_risk, { 65.0, 5.0, 20.0 }, { 70.0, 10.0, 30.0 });
        organs.add("below", mesh::Role::at_risk, { 38.0, 32.0, 20.0 }, { 40.0, 40.0, 30.0 });
        organs.add("past the end", mesh::Role::at_risk, { 43.0, 24.0, 60.0 }, { 50.0, 30.0, 70.0 }); // 3-4-5
        organs.add("elsewhere", mesh::Role::at_risk, { 91.0, 5.0, 20.0 }, { 95.0, 10.0, 30.0 });
        organs.add("no risk", mesh::Role::voxel, { 45.0, 5.0, 20.0 }, { 46.0, 10.0, 30.0 });
        const std::vector<RiskDistance> found = organs.distances();
        ASSERT_EQ(found.size(), 3U);
        EXPECT_EQ(found[0].name, "past the end");
        EXPECT_NEAR(found[0].distance_mm, 5.0, kRoundOff);
        EXPECT_LT((found[0].at - Vec3(43.0, 24.0, 60.0)).norm(), kRoundOff);
        EXPECT_EQ(found[1].name, "below");
        EXPECT_NEAR(found[1].distance_mm, 12.0, kRoundOff);
        EXPECT_EQ(found[2].name, "beside");
        EXPECT_NEAR(found[2].distance_mm, 25.0, kRoundOff);
    }

    TEST(RiskDistances, ABladeThroughAStructureIsNoDistance)
    {
        Organs organs;
        organs.add("pierced", mesh::Role::at_risk, { 30.0, 15.0, 20.0 }, { 50.0, 60.0, 30.0 });
        const std::vector<RiskDistance> found = organs.distances();
        ASSERT_EQ(found.size(), 1U);
        EXPECT_EQ(found[0].distance_mm, 0.0);
    }

    TEST(RiskDistances, OfAnAssumedVesselCountFromItsWall)
    {
        const TriMesh cut = mesh::SweptBlade(straight_blade()).surface();
        const std::vector<AssumedVessel> vessels {
            { .name = "beside", .line = { { 46.0, 10.0, 0.0 }, { 46.0, 10.0, 80.0 } }, .radius_mm = 1.5 },
            { .name = "across", .line = { { 20.0, 10.0, 30.0 }, { 60.0, 10.0, 30.0 } }, .radius_mm = 1.0 },
            { .name = "thin", .line = { { 39.93, 10.0, 31.0 }, { 60.0, 10.0, 31.0 } }, .radius_mm = 0.1 },
            { .name = "far", .line = { { 95.0, 10.0, 0.0 }, { 95.0, 10.0, 80.0 } }, .radius_mm = 1.0 },
        };
        const std::vector<RiskDistance> found = assumed_distances(cut, vessels);
        ASSERT_EQ(found.size(), 3U);
        EXPECT_EQ(found[0].name, "across");
        EXPECT_EQ(found[0].distance_mm, 0.0) << "it is cut";
        EXPECT_EQ(found[1].name, "thin");
        EXPECT_EQ(found[1].distance_mm, 0.0) << "however thin it is";
        EXPECT_NEAR(found[2].distance_mm, 6.0 - 1.5, kRoundOff);
        EXPECT_TRUE(found[2].is_assumed);
        EXPECT_EQ(risk_name(found[2]), "beside (assumed place)");
        EXPECT_TRUE(assumed_distances(cut, {}).empty());
    }

    TEST(RiskDistances, OfTheBundlesTheNearestIsKept)
    {
        std::vector<RiskDistance> risks {
            { .name = "neurovascular_bundle_left_4", .distance_mm = 5.0, .is_assumed = true },
            { .name = "mammary_artery_left", .distance_mm = 9.0, .is_assumed = true },
            { .name = "neurovascular_bundle_left_5", .distance_mm = 12.0, .is_assumed = true },
            { .name = "heart", .distance_mm = 20.0 }
        };
        keep_nearest_bundle(risks);
        std::vector<RiskDistance> cut = risks;
        ASSERT_EQ(risks.size(), 3U);
        for (RiskDistance& risk : cut)
            risk.distance_mm = 0.0;
        cut.push_back({ .name = "neurovascular_bundle_left_6", .is_assumed = true });
        keep_nearest_bundle(cut);
        EXPECT_EQ(cut.size(), 4U) << "what is cut is named";
        EXPECT_EQ(risks[0].name, "neurovascular_bundle_left_4");
        EXPECT_EQ(risks[1].name, "mammary_artery_left");
        EXPECT_EQ(risks[2].name, "heart");
    }

    TEST(RiskDistances, OfSeveralBladesTheNearestCounts)
    {
        const auto found
            = nearest_risks({ { .name = "heart", .distance_mm = 8.0 }, { .name = "aorta", .distance_mm = 12.0 },
                { .name = "artery", .distance_mm = 6.0 }, { .name = "heart", .distance_mm = 3.0 } });
        ASSERT_EQ(found.size(), 3U);
        EXPECT_EQ(found[0].name, "heart");
        EXPECT_EQ(found[0].distance_mm, 3.0);
        EXPECT_EQ(found[1].name, "artery");
        EXPECT_EQ(found[2].name, "aorta");
    }

    TEST(RiskDistances, OfAnInstrumentNameItAndTheNearestPlace)
    {
        Organs organs;
        organs.add("beside", mesh::Role::at_risk, { 65.0, 5.0, 20.0 }, { 70.0, 10.0, 30.0 });
        organs.add("far", mesh::Role::at_risk, { 105.0, 5.0, 20.0 }, { 110.0, 10.0, 30.0 });
        organs.add("no risk", mesh::Role::voxel, { 51.0, 5.0, 20.0 }, { 52.0, 10.0, 30.0 });
        TriMesh plate;
        plate.vertices.resize(3, 3);
        plate.vertices << 50.0, 5.0, 20.0, 50.0, 10.0, 20.0, 50.0, 5.0, 30.0;
        plate.triangles = { { 0, 1, 2 } };
        const auto found = risk_distances(plate, "left_blade", organs.labels.table,
            [&](std::string_view name) { return organs.surfaces.find(name)->second; });
        ASSERT_EQ(found.size(), 1U);
        EXPECT_EQ(found[0].name, "beside");
        EXPECT_EQ(found[0].from, "left_blade");
        EXPECT_NEAR(found[0].distance_mm, 15.0, kRoundOff);
        EXPECT_NEAR(found[0].at.x(), 65.0, kRoundOff);
    }

    TEST(RiskDistances, AStructureWithoutASurfaceIsNotListed)
    {
        Organs organs;
        organs.add("gone", mesh::Role::at_risk, { 65.0, 5.0, 20.0 }, { 70.0, 10.0, 30.0 });
        organs.surfaces["gone"] = std::make_shared<const TriMesh>();
        EXPECT_TRUE(organs.distances().empty());
    }

} // namespace risk_distances_test
} // namespace retractor::planner
