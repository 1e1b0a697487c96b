#include "planner/anatomy/bone_stiffness.h"

#include "mesh/base/error.h"
#include "tests/support/reference_problems.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {
namespace bone_stiffness_test {

    constexpr Label kRib = 4, kMuscle = 3, kCartilage = 7;
    /// Of a recovered modulus: the outline is known to half a voxel, which is a tenth of the thickness of a rib.
    constexpr double kTolerance = 0.15;
    const Vec3 kHalfResolution(1.4, 1.4, 2.5); // mm: voxels of a chest CT at half resolution

    mesh::LabelTable table()
    {
        return { { kMuscle, "muscle", "muscle", mesh::Role::wall }, { kRib, "rib_left_5", "bone", mesh::Role::wall },
            { kCartilage, "costal_cartilages", "cartilage", mesh::Role::wall } };
    }

    /// A rib that is an elliptic tube along an arc of 100 degrees.
    struct Tube {
        double across = 3.8, along = 6.0; ///< semi-axes of the outline, mm
        double cortex_mm = 0.8;
        double radius_mm = 90.0;
        double cortex_HU = kCortexHU, marrow_HU = kMarrowHU;
        bool lung = false; ///< air inside the chest, 2 mm from the rib

        enum class Tissue { muscle, cortex, marrow, lung };
        Tissue at(const Vec3& p) const
        {
            const double reach = 50.0 * std::numbers::pi / 180.0;
            const double r = std::hypot(p.x(), p.y()) - radius_mm;
            const auto inside = [&](double a, double b) { return std::pow(r / a, 2) + std::pow(p.z() / b, 2) < 1.0; };
            if (std::abs(std::atan2(p.y(), p.x())) < reach) {
                if (inside(across - cortex_mm, along - cortex_mm))
                    return Tissue::marrow;
                if (inside(across, along))
                    return Tissue::cortex;
            }
            return lung && r < -across - 2.0 ? Tissue::lung : Tissue::muscle;
        }
        double value(const Vec3& p) const
        {
            switch (at(p)) {
            case Tissue::cortex:
                return cortex_HU;
            case Tissue::marrow:
                return marrow_HU;
            case Tissue::lung:
                return -850.0;
            case Tissue::muscle:
                break;
            }
            return 50.0;
        }
        /// Second moment of the shell over that of the outline, the mean over both axes, times the modulus of cortex.
        double modulus_MPa() const
        {
            const double a = across, b = along, c = a - cortex_mm, d = b - cortex_mm;
            const double about_a = 1.0 - c * d * d * d / (a * b * b * b),
                         about_b = 1.0 - d * c * c * c / (b * a * a * a);
            return kCorticalBoneMPa * 0.5 * (about_a + about_b);
        }
    };

    struct Scan {
        mesh::LabelVolume labels;
        mesh::Volume ct;
    };

    /// Scans the tube in a random pose. Each CT value is the mean over a triangle of two voxels' width, as by a
    /// scanner that blurs by a voxel; a label covers the voxels that the outline fills at least half.
    Scan scan(const Tube& tube, const Vec3& spacing, double noise_HU, unsigned seed)
    {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> place(-0.5, 0.5);
        std::normal_distribution<double> noise(0.0, 1.0);
        const Mat3 pose = Eigen::Quaterniond(noise(random), noise(random), noise(random), noise(random))
                              .normalized()
                              .toRotationMatrix();
        const Vec3 middle = tube.radius_mm * 0.85 * Vec3::UnitX();
        Vec3 low = Vec3::Constant(1e9), high = -low;
        for (double degrees = -50.0; degrees <= 50.0; degrees += 1.0) {
            const double angle = degrees * std::numbers::pi / 180.0;
            const Vec3 p = pose * (Vec3(std::cos(angle), std::sin(angle), 0.0) * tube.radius_mm - middle);
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
        Scan made;
        mesh::ImageGrid& grid = made.labels.grid;
        grid.spacing = spacing;
        grid.origin
            = low - Vec3::Constant(12.0) + spacing.cwiseProduct(Vec3(place(random), place(random), place(random)));
        for (int a = 0; a < 3; ++a)
            grid.size[static_cast<std::size_t>(a)] = static_cast<int>((high[a] - low[a] + 24.0) / spacing[a]);
        made.labels.table = table();
        made.ct.grid = grid;
        constexpr int kSamples = 60;
        for (int k = 0; k < grid.size[2]; ++k)
            for (int j = 0; j < grid.size[1]; ++j)
                for (int i = 0; i < grid.size[0]; ++i) {
                    const auto local = [&](const Vec3& at) { return Vec3(pose.transpose() * grid.world(at) + middle); };
                    const Vec3 centre(i, j, k);
                    double value = 0.0, filled = 0.0;
                    const Vec3 here = local(centre);
                    const bool near = std::hypot(std::hypot(here.x(), here.y()) - tube.radius_mm, here.z())
                        < tube.along + 2.0 * spacing.maxCoeff();
                    const int samples = near ? kSamples : 1;
                    for (int n = 0; n < samples; ++n) {
                        const Vec3 box = near ? Vec3(place(random), place(random), place(random)) : Vec3::Zero();
                        const Vec3 more = near ? Vec3(place(random), place(random), place(random)) : Vec3::Zero();
                        value += tube.value(local(centre + box + more)) / samples;
                        const Tube::Tissue tissue = tube.at(local(centre + box));
                        filled
                            += tissue == Tube::Tissue::cortex || tissue == Tube::Tissue::marrow ? 1.0 / samples : 0.0;
                    }
                    made.labels.voxels.push_back(filled >= 0.5 ? kRib : kMuscle);
                    made.ct.voxels.push_back(static_cast<std::int16_t>(std::lround(value + noise_HU * noise(random))));
                }
        return made;
    }

    const BoneStiffness& only(const std::vector<BoneStiffness>& bones)
    {
        EXPECT_EQ(bones.size(), 1U);
        return bones.front();
    }

    TEST(BoneStiffness, IsRecoveredFromBlurredTubes)
    {
        unsigned seed = 1;
        for (const double cortex_mm : { 0.4, 0.6, 0.8 })
            for (const bool lung : { false, true })
                for (const double noise : { 0.0, 30.0 }) {
                    Tube tube;
                    tube.cortex_mm = cortex_mm;
                    tube.lung = lung;
                    const Scan image = scan(tube, kHalfResolution, noise, seed++);
                    const auto bones = find_bone_stiffness(image.labels, &image.ct, fem::default_materials());
                    const BoneStiffness& rib = only(bones);
                    EXPECT_EQ(rib.origin, StiffnessOrigin::image) << rib.words;
                    EXPECT_NEAR(rib.modulus_MPa, tube.modulus_MPa(), kTolerance * tube.modulus_MPa()) << seed;
                    EXPECT_LT(rib.low_MPa, tube.modulus_MPa());
                    EXPECT_GT(rib.high_MPa, tube.modulus_MPa());
                    EXPECT_GE(rib.sections, 12U);
                }
    }

    TEST(BoneStiffness, OfAFineScanIsTheSame)
    {
        const Tube tube { .cortex_mm = 0.6 };
        const Scan image = scan(tube, Vec3(0.8, 0.8, 1.2), 40.0, 21);
        const auto bones = find_bone_stiffness(image.labels, &image.ct, fem::default_materials());
        EXPECT_NEAR(only(bones).modulus_MPa, tube.modulus_MPa(), kTolerance * tube.modulus_MPa());
    }

    TEST(BoneStiffness, NeedsNoCommonGrid)
    {
        const Tube tube { .cortex_mm = 0.6 };
        Scan image = scan(tube, kHalfResolution, 0.0, 22);
        // Labels of every second voxel in the plane, on a grid of their own.
        mesh::LabelVolume coarse;
        coarse.table = image.labels.table;
        coarse.grid = image.labels.grid;
        coarse.grid.spacing.head<2>() *= 0.5;
        coarse.grid.size[0] = 2 * coarse.grid.size[0] - 1;
        coarse.grid.size[1] = 2 * coarse.grid.size[1] - 1;
        for (int k = 0; k < coarse.grid.size[2]; ++k)
            for (int j = 0; j < coarse.grid.size[1]; ++j)
                for (int i = 0; i < coarse.grid.size[0]; ++i)
                    coarse.voxels.push_back(mesh::label_at(image.labels, coarse.grid.world(Vec3(i, j, k))));
        const auto bones = find_bone_stiffness(coarse, &image.ct, fem::default_materials());
        EXPECT_NEAR(only(bones).modulus_MPa, tube.modulus_MPa(), kTolerance * tube.modulus_MPa());
    }

    TEST(BoneStiffness, IsTheMiddleWhereTheCTCannotTell)
    {
        const auto expect_middle = [](const Scan& image, const mesh::Volume* ct, const std::string& why) {
            const auto bones = find_bone_stiffness(image.labels, ct, fem::default_materials(), "no image");
            const BoneStiffness& rib = only(bones);
            EXPECT_EQ(rib.origin, StiffnessOrigin::middle);
            EXPECT_EQ(rib.modulus_MPa, kMiddleRibMPa);
            EXPECT_EQ(rib.low_MPa, kSoftestRibMPa);
            EXPECT_EQ(rib.high_MPa, kStiffestRibMPa);
            EXPECT_NE(rib.words.find(why), std::string::npos) << rib.words;
        };
        for (const unsigned seed : { 31U, 32U, 33U }) {
            const Scan solid = scan({ .cortex_HU = 700.0, .marrow_HU = 700.0 }, kHalfResolution, 25.0, seed);
            expect_middle(solid, &solid.ct, "no marrow");
            expect_middle(solid, nullptr, "no image");
            const Scan dark = scan({ .cortex_HU = 90.0, .marrow_HU = 60.0 }, kHalfResolution, 10.0, seed);
            expect_middle(dark, &dark.ct, "looks like cortex");
        }
        Scan few = scan({}, kHalfResolution, 0.0, 34);
        std::size_t kept = 0;
        for (Label& label : few.labels.voxels)
            if (label == kRib && ++kept > 20)
                label = kMuscle;
        expect_middle(few, &few.ct, "too few voxels");
    }

    TEST(BoneStiffness, IsCutOffWithAMessage)
    {
        for (const auto& [cortex_mm, limit] :
            { std::pair { 0.15, kSoftestRibMPa }, std::pair { 1.6, kStiffestRibMPa } }) {
            Tube tube;
            tube.cortex_mm = cortex_mm;
            const Scan image = scan(tube, kHalfResolution, 0.0, 41);
            const auto bones = find_bone_stiffness(image.labels, &image.ct, fem::default_materials());
            const BoneStiffness& rib = only(bones);
            EXPECT_EQ(rib.modulus_MPa, limit);
            ASSERT_TRUE(rib.cut_off_MPa);
            EXPECT_NEAR(*rib.cut_off_MPa, tube.modulus_MPa(), kTolerance * tube.modulus_MPa() + 300.0);
            EXPECT_NE(rib.words.find("cut off"), std::string::npos) << rib.words;
        }
    }

    TEST(BoneStiffness, OfTheCaseWins)
    {
        const Scan image = scan({}, kHalfResolution, 0.0, 51);
        fem::MaterialTable materials = fem::default_materials();
        for (fem::Material& material : materials)
            if (material.name == "bone") {
                material.youngs_modulus_MPa = 3210.0;
                material.source = "measured";
            }
        const auto bones = find_bone_stiffness(image.labels, &image.ct, materials);
        EXPECT_EQ(only(bones).origin, StiffnessOrigin::own);
        EXPECT_EQ(only(bones).modulus_MPa, 3210.0);
        std::vector<fem::Material> of_label(kCartilage + 1U, fem::find_material(materials, "bone"));
        apply_bone_stiffness(bones, of_label);
        EXPECT_EQ(of_label[kRib].youngs_modulus_MPa, 3210.0);
        EXPECT_EQ(of_label[kRib].source, "measured");

        // The default of an earlier version is nobody's own value.
        for (fem::Material& material : materials)
            if (material.name == "bone") {
                material.youngs_modulus_MPa = 1000.0;
                material.source = "PMC6584379: whole rib, homogenised over cortex and marrow; cortical bone alone";
            }
        const auto found = find_bone_stiffness(image.labels, &image.ct, materials);
        EXPECT_EQ(only(found).origin, StiffnessOrigin::image);
        apply_bone_stiffness(found, of_label);
        EXPECT_EQ(of_label[kRib].youngs_modulus_MPa, only(found).modulus_MPa);
        EXPECT_EQ(of_label[kRib].source, only(found).words);
        EXPECT_EQ(of_label[kRib].name, "bone");
    }

    TEST(BoneStiffness, OfASectionIsThatOfATube)
    {
        EXPECT_EQ(section_modulus_MPa(0.0), 0.0);
        EXPECT_EQ(section_modulus_MPa(1.0), kCorticalBoneMPa);
        // A round tube of radii 5 and 4: the share in the second moment is 1 - (4 / 5)^4.
        const double share = 1.0 - 16.0 / 25.0;
        EXPECT_NEAR(section_modulus_MPa(share), kCorticalBoneMPa * (1.0 - 256.0 / 625.0), 1e-9 * kCorticalBoneMPa);
    }

    /// A bar of cartilage along x with a rib at its end.
    Scan cartilage_bar(const std::function<double(const Vec3&)>& value)
    {
        Scan made;
        made.labels.grid.size = { 40, 12, 12 };
        made.labels.grid.spacing = Vec3(1.4, 1.4, 2.5);
        made.labels.table = table();
        made.ct.grid = made.labels.grid;
        for (int k = 0; k < 12; ++k)
            for (int j = 0; j < 12; ++j)
                for (int i = 0; i < 40; ++i) {
                    const bool inside = j >= 3 && j < 9 && k >= 3 && k < 9;
                    made.labels.voxels.push_back(!inside ? kMuscle : i < 10 ? kRib : kCartilage);
                    made.ct.voxels.push_back(static_cast<std::int16_t>(value(Vec3(i, j, k))));
                }
        return made;
    }

    TEST(CartilageStiffness, GrowsWithTheCalcifiedShare)
    {
        const Scan plain = cartilage_bar([](const Vec3& v) { return v.x() < 12.0 ? 700.0 : 100.0; });
        EXPECT_EQ(calcified_share(plain.labels, kCartilage, plain.ct), 0.0); // bone shines into two voxels only
        EXPECT_NEAR(cartilage_modulus_MPa(0.0), 28.5, 1e-12);

        // A quarter of the voxels clear of bone is calcified.
        const Scan calcified = cartilage_bar([](const Vec3& v) { return std::fmod(v.x(), 4.0) == 0.0 ? 400.0 : 90.0; });
        const std::optional<double> share = calcified_share(calcified.labels, kCartilage, calcified.ct);
        ASSERT_TRUE(share);
        EXPECT_NEAR(*share, 0.25, 0.02);

        // 24 % calcified: 2.3 to 3.8 times as stiff.
        EXPECT_GT(cartilage_modulus_MPa(0.24) / cartilage_modulus_MPa(0.0), 2.3);
        EXPECT_LT(cartilage_modulus_MPa(0.24) / cartilage_modulus_MPa(0.0), 3.8);
        EXPECT_NEAR(cartilage_modulus_MPa(1.0), kMostStiffening * 28.5, 1e-9);

        const auto bones = find_bone_stiffness(calcified.labels, &calcified.ct, fem::default_materials());
        ASSERT_EQ(bones.size(), 2U);
        EXPECT_EQ(bones[1].name, "costal_cartilages");
        EXPECT_EQ(bones[1].modulus_MPa, cartilage_modulus_MPa(*share));
        EXPECT_EQ(bones[0].origin, StiffnessOrigin::middle); // 14 mm of a rib are too few
    }

    TEST(CartilageStiffness, WithoutACTHasNoCalcification)
    {
        const Scan bar = cartilage_bar([](const Vec3&) { return 0.0; });
        const auto bones = find_bone_stiffness(bar.labels, nullptr, fem::default_materials());
        ASSERT_EQ(bones.size(), 2U);
        EXPECT_NEAR(
            bones[1].modulus_MPa, fem::find_material(fem::default_materials(), "cartilage").youngs_modulus_MPa, 1e-12);
        EXPECT_NEAR(bones[1].low_MPa, 9.5, 1e-12);
        EXPECT_NEAR(bones[1].high_MPa, 47.5, 1e-12);
    }

    TEST(BoneStiffness, RefusesBadInputByName)
    {
        const Scan image = scan({}, Vec3::Constant(3.0), 0.0, 61);
        EXPECT_EQ(
            test_support::message_of([&] { (void)measure_rib_sections(image.labels, kRib, image.ct, 500.0, 400.0); }),
            "cortex_HU: the value of cortex (400 HU) must be above that of marrow (500 HU)");
        EXPECT_EQ(test_support::message_of([&] { (void)measure_rib_sections(image.labels, kRib, image.ct, NAN); }),
            "cortex_HU: the value of cortex (1600 HU) must be above that of marrow (nan HU)");
        EXPECT_EQ(test_support::message_of([] { (void)section_modulus_MPa(1.2); }),
            "share: a share must lie between 0 and 1, got 1.2");
        EXPECT_EQ(test_support::message_of([] { (void)cartilage_modulus_MPa(-0.1); }),
            "share: a share must lie between 0 and 1, got -0.1");
        EXPECT_NE(test_support::message_of([&] { (void)find_bone_stiffness(image.labels, nullptr, {}); }).find("bone"),
            std::string::npos);
    }

} // namespace bone_stiffness_test
} // namespace retractor::planner
