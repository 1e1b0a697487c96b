#include "datasets/phantoms/phantom.h"

#include "datasets/phantoms/phantom_shapes.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"

#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace retractor::datasets {
namespace phantom_test {

    /// The default phantom, made once.
    const Phantom& thorax()
    {
        static const Phantom kThorax = make_thorax_phantom({});
        return kThorax;
    }

    ThoraxParameters coarse()
    {
        ThoraxParameters parameters;
        parameters.spacing_mm = { 4.0, 4.0, 4.0 };
        return parameters;
    }

    Label id_of(const mesh::LabelVolume& labels, const std::string& name)
    {
        const mesh::LabelInfo* info = mesh::find_label(labels.table, name);
        EXPECT_NE(info, nullptr) << name;
        return info == nullptr ? Label { 0 } : info->id;
    }

    template <typename Visit> void for_each_voxel(const mesh::ImageGrid& grid, const Visit& visit)
    {
        std::size_t v = 0;
        for (int k = 0; k < grid.size[2]; ++k)
            for (int j = 0; j < grid.size[1]; ++j)
                for (int i = 0; i < grid.size[0]; ++i, ++v)
                    visit(i, j, k, v);
    }

    struct Extent {
        std::size_t voxels = 0;
        Vec3 centroid = Vec3::Zero();
        Vec3 low = Vec3::Constant(1e9);
        Vec3 high = Vec3::Constant(-1e9);
        double mean_hu = 0.0;
    };

    std::map<Label, Extent> extents(const Phantom& phantom)
    {
        std::map<Label, Extent> result;
        for_each_voxel(phantom.labels.grid, [&](int i, int j, int k, std::size_t v) {
            Extent& e = result[phantom.labels.voxels[v]];
            const Vec3 p = phantom.labels.grid.world(Vec3(i, j, k));
            ++e.voxels;
            e.centroid += p;
            e.low = e.low.cwiseMin(p);
            e.high = e.high.cwiseMax(p);
            e.mean_hu += phantom.ct.voxels[v];
        });
        for (auto& [label, e] : result) {
            e.centroid /= static_cast<double>(e.voxels);
            e.mean_hu /= static_cast<double>(e.voxels);
        }
        return result;
    }

    /// Number of pieces of a label, with 26 neighbours.
    int pieces(const mesh::LabelVolume& labels, Label label)
    {
        std::vector<bool> seen(labels.voxels.size(), false);
        std::vector<std::array<int, 3>> stack;
        int count = 0;
        for_each_voxel(labels.grid, [&](int i, int j, int k, std::size_t v) {
            if (labels.voxels[v] != label || seen[v])
                return;
            ++count;
            seen[v] = true;
            stack.push_back({ i, j, k });
            while (!stack.empty()) {
                const auto [x, y, z] = stack.back();
                stack.pop_back();
                for (int n = 0; n < 27; ++n) {
                    const int a = x + n % 3 - 1;
                    const int b = y + (n / 3) % 3 - 1;
                    const int c = z + n / 9 - 1;
                    if (!labels.grid.contains(a, b, c))
                        continue;
                    const std::size_t at = labels.grid.offset(a, b, c);
                    if (labels.voxels[at] == label && !seen[at]) {
                        seen[at] = true;
                        stack.push_back({ a, b, c });
                    }
                }
            }
        });
        return count;
    }

    /// Calls `bad` for every face between skin or fat and a voxel of the inside (or, for fat, air).
    template <typename Bad> void scan_wall(const mesh::LabelVolume& labels, const Bad& bad)
    {
        std::map<Label, int> side; // 1 skin, 2 fat, 3 inside
        for (const mesh::LabelInfo& info : labels.table)
            side[info.id] = info.name == "skin" ? 1 : info.name == "fat" ? 2 : info.role != mesh::Role::wall ? 3 : 0;
        side[0] = 4;
        for_each_voxel(labels.grid, [&](int i, int j, int k, std::size_t v) {
            for (const auto& [di, dj, dk] : { std::array { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }) {
                if (!labels.grid.contains(i + di, j + dj, k + dk))
                    continue;
                int a = side[labels.voxels[v]];
                int b = side[labels.voxels[labels.grid.offset(i + di, j + dj, k + dk)]];
                if (a > b)
                    std::swap(a, b);
                if ((b == 3 && (a == 1 || a == 2)) || (a == 2 && b == 4) || (a == 3 && b == 4) || (a == 0 && b == 4))
                    bad(labels.voxels[v], labels.voxels[labels.grid.offset(i + di, j + dj, k + dk)],
                        Eigen::Vector3i(i, j, k));
            }
        });
    }

    TEST(ThoraxPhantom, TheSameSeedGivesTheSameVoxels)
    {
        const Phantom a = make_thorax_phantom(coarse());
        const Phantom b = make_thorax_phantom(coarse());
        EXPECT_EQ(a.ct.voxels, b.ct.voxels);
        EXPECT_EQ(a.labels.voxels, b.labels.voxels);
        ThoraxParameters other = coarse();
        other.seed = 2;
        const Phantom c = make_thorax_phantom(other);
        EXPECT_NE(a.ct.voxels, c.ct.voxels);
        EXPECT_EQ(a.labels.voxels, c.labels.voxels);
    }

    TEST(ThoraxPhantom, HasTheAgreedLabels)
    {
        const mesh::LabelVolume& labels = thorax().labels;
        const auto present = extents(thorax());
        const std::map<std::string, std::pair<std::string, mesh::Role>> agreed {
            { "skin", { "skin", mesh::Role::wall } }, { "fat", { "fat", mesh::Role::wall } },
            { "muscle", { "muscle", mesh::Role::wall } }, { "intercostal", { "intercostal", mesh::Role::wall } },
            { "costal_cartilages", { "cartilage", mesh::Role::wall } }, { "sternum", { "bone", mesh::Role::wall } },
            { "spine", { "bone", mesh::Role::wall } }, { "scapula_left", { "bone", mesh::Role::wall } },
            { "scapula_right", { "bone", mesh::Role::wall } }, { "lung_left", { "lung", mesh::Role::voxel } },
            { "lung_right", { "lung", mesh::Role::voxel } }, { "heart", { "heart", mesh::Role::at_risk } },
            { "pericardium", { "heart", mesh::Role::voxel } }, { "aorta", { "vessel", mesh::Role::at_risk } },
            { "aneurysm", { "vessel", mesh::Role::target } }, { "coronary_target", { "vessel", mesh::Role::target } },
            { "mediastinal_fat", { "fat", mesh::Role::voxel } }
        };
        for (const auto& [name, what] : agreed) {
            const mesh::LabelInfo* info = mesh::find_label(labels.table, name);
            ASSERT_NE(info, nullptr) << name;
            EXPECT_EQ(info->material, what.first) << name;
            EXPECT_EQ(info->role, what.second) << name;
            EXPECT_TRUE(present.contains(info->id)) << name;
        }
        for (const mesh::LabelInfo& info : labels.table)
            EXPECT_TRUE(present.contains(info.id)) << info.name << " has no voxel";
    }

    TEST(ThoraxPhantom, EveryBoneIsOnePiece)
    {
        const mesh::LabelVolume& labels = thorax().labels;
        for (const mesh::LabelInfo& info : labels.table)
            if (info.material == "bone") {
                EXPECT_EQ(pieces(labels, info.id), 1) << info.name;
            }
    }

    TEST(ThoraxPhantom, RibsStandInOrderAndLeftIsPlusX)
    {
        const auto where = extents(thorax());
        const mesh::LabelVolume& labels = thorax().labels;
        for (int rib = 1; rib <= 12; ++rib) {
            const Extent& left = where.at(id_of(labels, "rib_left_" + std::to_string(rib)));
            const Extent& right = where.at(id_of(labels, "rib_right_" + std::to_string(rib)));
            EXPECT_GT(left.low.x(), 0.0);
            EXPECT_LT(right.high.x(), 0.0);
            EXPECT_NEAR(left.centroid.x(), -right.centroid.x(), labels.grid.spacing.x());
            if (rib > 1) {
                EXPECT_LT(left.centroid.z(),
                    where.at(id_of(labels, "rib_left_" + std::to_string(rib - 1))).centroid.z() - 10.0);
            }
        }
        EXPECT_GT(where.at(id_of(labels, "lung_left")).centroid.x(), 20.0);
        EXPECT_LT(where.at(id_of(labels, "lung_right")).centroid.x(), -20.0);
        EXPECT_GT(where.at(id_of(labels, "heart")).centroid.x(), 5.0); // points left
        EXPECT_GT(where.at(id_of(labels, "aneurysm")).centroid.x(), 30.0);
        const double heart_y = where.at(id_of(labels, "heart")).centroid.y();
        EXPECT_GT(where.at(id_of(labels, "aneurysm")).centroid.y(), heart_y);
        EXPECT_LT(where.at(id_of(labels, "coronary_target")).centroid.y(), heart_y);
        EXPECT_LT(
            where.at(id_of(labels, "sternum")).centroid.y(), where.at(id_of(labels, "spine")).centroid.y() - 100.0);
        EXPECT_GT(where.at(id_of(labels, "aorta")).centroid.z(), where.at(id_of(labels, "liver")).centroid.z());
    }

    TEST(ThoraxPhantom, TheWallHasNoHole)
    {
        for (const double fat : { 3.0, 20.0 }) {
            ThoraxParameters parameters = coarse();
            parameters.spacing_mm = { 3.0, 3.0, 3.0 };
            parameters.fat_mm = fat;
            parameters.noise_hu = 0.0;
            if (fat > 10.0) {
                parameters.width_mm = 380.0;
                parameters.depth_mm = 260.0;
            }
            const Phantom phantom = make_thorax_phantom(parameters);
            int holes = 0;
            scan_wall(phantom.labels, [&](Label, Label, const Eigen::Vector3i&) { ++holes; });
            EXPECT_EQ(holes, 0) << "fat " << fat;
        }
        std::string first;
        scan_wall(thorax().labels, [&](Label a, Label b, const Eigen::Vector3i& at) {
            if (first.empty())
                first = std::to_string(a) + " beside " + std::to_string(b) + " at " + std::to_string(at.x()) + " "
                    + std::to_string(at.y()) + " " + std::to_string(at.z());
        });
        EXPECT_EQ(first, "");
    }

    TEST(ThoraxPhantom, ThePleuraIsSoftTissueEverywhere)
    {
        // A cut down to the pleura never ends on bone: lungs touch intercostal tissue or muscle, never a bone.
        const mesh::LabelVolume& labels = thorax().labels;
        std::set<Label> bones;
        for (const mesh::LabelInfo& info : labels.table)
            if (info.material == "bone" || info.material == "cartilage")
                bones.insert(info.id);
        bones.erase(id_of(labels, "trachea"));
        const std::set<Label> lungs { id_of(labels, "lung_left"), id_of(labels, "lung_right") };
        int contacts = 0;
        for_each_voxel(labels.grid, [&](int i, int j, int k, std::size_t v) {
            if (!lungs.contains(labels.voxels[v]))
                return;
            for (const auto& [di, dj, dk] :
                { std::array { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 } })
                if (labels.grid.contains(i + di, j + dj, k + dk)
                    && bones.contains(labels.voxels[labels.grid.offset(i + di, j + dj, k + dk)]))
                    ++contacts;
        });
        EXPECT_EQ(contacts, 0);
    }

    TEST(ThoraxPhantom, TargetsHaveTheSizeAskedFor)
    {
        const auto volume_ml = [](const Phantom& phantom, const char* name) {
            return static_cast<double>(extents(phantom)[id_of(phantom.labels, name)].voxels)
                * phantom.labels.grid.voxel_volume() / 1000.0;
        };
        const auto sphere_ml = [](double d) { return std::numbers::pi / 6.0 * d * d * d / 1000.0; };
        // An ellipsoid with diameters d, 0.96 d and 1.06 d; none of it is cut away by the chest wall.
        EXPECT_NEAR(volume_ml(thorax(), "aneurysm") / (0.96 * 1.06 * sphere_ml(55.0)), 1.0, 0.03);
        EXPECT_NEAR(volume_ml(thorax(), "coronary_target") / sphere_ml(12.0), 1.0, 0.1);
        ThoraxParameters small;
        small.aneurysm_diameter_mm = 40.0;
        const Phantom phantom = make_thorax_phantom(small);
        EXPECT_NEAR(volume_ml(phantom, "aneurysm") / (0.96 * 1.06 * sphere_ml(40.0)), 1.0, 0.03);
        EXPECT_GT(volume_ml(thorax(), "heart"), 400.0);
        EXPECT_LT(volume_ml(thorax(), "heart"), 800.0);
    }

    TEST(ThoraxPhantom, SizeAndLayersFollowTheParameters)
    {
        ThoraxParameters parameters = coarse();
        parameters.spacing_mm = { 2.0, 2.0, 4.0 };
        parameters.width_mm = 380.0;
        parameters.depth_mm = 270.0;
        parameters.height_mm = 340.0;
        parameters.fat_mm = 15.0;
        const Phantom phantom = make_thorax_phantom(parameters);
        const auto where = extents(phantom);
        const Extent& skin = where.at(id_of(phantom.labels, "skin"));
        EXPECT_NEAR(skin.high.x() - skin.low.x(), 380.0, 2.0 * 2.0);
        EXPECT_NEAR(skin.high.y() - skin.low.y(), 270.0, 3.0 * 2.0);
        EXPECT_NEAR(skin.high.z() - skin.low.z(), 340.0, 4.0);
        // Along the flank at mid height: skin, fat, muscle, counted inwards from the left.
        std::map<Label, double> thickness;
        const mesh::ImageGrid& grid = phantom.labels.grid;
        const Eigen::Vector3i at = grid.index(Vec3(0.0, 0.0, 0.0)).array().round().cast<int>();
        for (int i = at.x(); i < grid.size[0]; ++i)
            thickness[phantom.labels.voxels[grid.offset(i, at.y(), at.z())]] += grid.spacing.x();
        EXPECT_NEAR(thickness[id_of(phantom.labels, "skin")], 3.0, 2.0);
        EXPECT_NEAR(thickness[id_of(phantom.labels, "fat")], 15.0, 2.0);
        EXPECT_GT(thickness[id_of(phantom.labels, "muscle")], 6.0);
    }

    TEST(ThoraxPhantom, AFieldOfViewIsASquareWithTheSamePatientInIt)
    {
        ThoraxParameters parameters = coarse();
        parameters.spacing_mm = { 4.0, 4.0, 6.0 };
        parameters.field_of_view_mm = 400.0;
        const Phantom wide = make_thorax_phantom(parameters);
        EXPECT_EQ(wide.ct.grid.size, (std::array<int, 3> { 100, 100, 50 }));
        parameters.field_of_view_mm = 0.0;
        const Phantom narrow = make_thorax_phantom(parameters);
        const auto voxels = [](const Phantom& p) {
            return static_cast<double>(
                std::count(p.labels.voxels.begin(), p.labels.voxels.end(), id_of(p.labels, "muscle")));
        };
        EXPECT_NEAR(voxels(wide), voxels(narrow), 0.05 * voxels(narrow)); // the same but for where voxel centres fall
    }

    TEST(ThoraxPhantom, HounsfieldUnitsAreThoseOfACt)
    {
        const auto where = extents(thorax());
        const mesh::LabelVolume& labels = thorax().labels;
        const auto mean = [&](const char* name) { return where.at(id_of(labels, name)).mean_hu; };
        EXPECT_NEAR(mean("muscle"), 50.0, 15.0);
        EXPECT_NEAR(mean("lung_left"), -840.0, 40.0);
        EXPECT_NEAR(mean("aneurysm"), 350.0, 30.0);
        EXPECT_LT(mean("fat"), -70.0);
        EXPECT_GT(mean("rib_left_5"), 250.0);
        EXPECT_GT(mean("sternum"), 200.0);
        EXPECT_NEAR(where.at(0).mean_hu, -1000.0, 25.0); // the skin blurs into it
        // The noise has the spread asked for: compare with the same phantom without it.
        ThoraxParameters quiet = coarse();
        quiet.noise_hu = 0.0;
        ThoraxParameters noisy = coarse();
        noisy.noise_hu = 15.0;
        const Phantom a = make_thorax_phantom(quiet);
        const Phantom b = make_thorax_phantom(noisy);
        double sum = 0.0;
        std::size_t count = 0;
        const Label muscle = id_of(a.labels, "muscle");
        for (std::size_t v = 0; v < a.ct.voxels.size(); ++v)
            if (a.labels.voxels[v] == muscle) { // away from the clamp at -1024
                sum += std::pow(b.ct.voxels[v] - a.ct.voxels[v], 2.0);
                ++count;
            }
        EXPECT_NEAR(std::sqrt(sum / static_cast<double>(count)), 15.0, 0.5);
    }

    TEST(ThoraxPhantom, RecordsPartsAndStopsWhenCancelled)
    {
        Ledger ledger;
        std::atomic<bool> cancel { false };
        Job job;
        job.ledger = &ledger;
        job.cancel = &cancel;
        make_thorax_phantom(coarse(), job);
        EXPECT_TRUE(ledger.has("voxels"));
        EXPECT_TRUE(ledger.has("labels"));
        cancel = true;
        EXPECT_TRUE(make_thorax_phantom(coarse(), job).ct.voxels.empty());
    }

    TEST(ThoraxPhantom, RefusesBadParameters)
    {
        const auto refused = [](const auto& change, const std::string& why) {
            ThoraxParameters parameters = coarse();
            change(parameters);
            test_support::expect_refused<InputError>([&] { make_thorax_phantom(parameters); }, why);
        };
        refused([](ThoraxParameters& p) { p.width_mm = 100.0; }, "width_mm must be between 260 and 460, got 100");
        refused([](ThoraxParameters& p) { p.depth_mm = std::nan(""); }, "depth_mm");
        refused([](ThoraxParameters& p) { p.spacing_mm.y() = 0.0; }, "spacing_mm");
        refused([](ThoraxParameters& p) { p.noise_hu = -1.0; }, "noise_hu");
        refused([](ThoraxParameters& p) { p.aneurysm_diameter_mm = 90.0; }, "aneurysm_diameter_mm");
        refused([](ThoraxParameters& p) { p.fat_mm = 40.0; }, "leave no room");
        refused([](ThoraxParameters& p) { p.field_of_view_mm = 300.0; }, "field_of_view_mm must be between 346");
    }

    TEST(BlockPhantom, LayersAreExact)
    {
        BlockParameters parameters;
        parameters.spacing_mm = { 1.0, 1.0, 1.0 };
        parameters.bone_bar = true;
        const Phantom block = make_block_phantom(parameters);
        const auto where = extents(block);
        const auto voxels = [&](const char* name) { return where.at(id_of(block.labels, name)).voxels; };
        EXPECT_EQ(voxels("skin"), 100U * 3U * 100U);
        EXPECT_EQ(voxels("fat"), 100U * 9U * 100U);
        EXPECT_EQ(voxels("bone"), 100U * 6U * 12U);
        EXPECT_EQ(voxels("muscle"), 100U * 12U * 100U - voxels("bone"));
        EXPECT_NEAR(static_cast<double>(voxels("target")), 4.0 / 3.0 * std::numbers::pi * 1000.0, 60.0);
        EXPECT_LT((where.at(id_of(block.labels, "target")).centroid - Vec3(0.0, 50.0, 0.0)).norm(), 0.5);
    }

    TEST(BlockPhantom, RefusesBadParameters)
    {
        const auto refused = [](const auto& change, const std::string& why) {
            BlockParameters parameters;
            change(parameters);
            test_support::expect_refused<InputError>([&] { make_block_phantom(parameters); }, why);
        };
        refused([](BlockParameters& p) { p.size_mm.x() = -1.0; }, "size_mm");
        refused([](BlockParameters& p) { p.skin_mm = 0.0; }, "skin_mm");
        refused([](BlockParameters& p) { p.muscle_mm = 100.0; }, "thicker than the block");
        refused([](BlockParameters& p) { p.target_depth_mm = 10.0; }, "target_depth_mm");
    }

    TEST(TransformedPhantom, MovesEveryVoxelAndKeepsItsValue)
    {
        const Phantom block = make_block_phantom({});
        const Mat3 rotation = test_support::oblique_rotation();
        const Vec3 shift(12.0, -40.0, 305.0);
        const Phantom moved = transformed(block, rotation, shift);
        EXPECT_EQ(moved.labels.voxels, block.labels.voxels);
        EXPECT_EQ(moved.ct.voxels, block.ct.voxels);
        for (const Vec3& p : { Vec3(0.0, 50.0, 0.0), Vec3(20.0, 1.0, -30.0), Vec3(-44.0, 8.0, 44.0) })
            EXPECT_EQ(mesh::label_at(moved.labels, rotation * p + shift), mesh::label_at(block.labels, p));
        Mat3 mirror = Mat3::Identity();
        mirror(0, 0) = -1.0;
        test_support::expect_refused<InputError>([&] { transformed(block, mirror, shift); }, "proper rotation");
        test_support::expect_refused<InputError>([&] { transformed(block, 2.0 * rotation, shift); }, "proper rotation");
    }

    TEST(PhantomShapes, NoiseIsStandardAndEllipsoidsAreSigned)
    {
        double sum = 0.0;
        double squares = 0.0;
        constexpr int kCount = 200000;
        for (int i = 0; i < kCount; ++i) {
            const double n = gaussian_noise(3, static_cast<std::uint64_t>(i));
            sum += n;
            squares += n * n;
        }
        EXPECT_NEAR(sum / kCount, 0.0, 0.01); // 4 standard errors
        EXPECT_NEAR(squares / kCount, 1.0, 0.015);
        EXPECT_NEAR(
            ellipsoid_distance({ 11.0, 0.0, 0.0 }, Vec3::Zero(), Mat3::Identity(), Vec3::Constant(10.0)), 1.0, 1e-12);
        EXPECT_LT(ellipsoid_distance({ 0.0, 3.0, 0.0 }, Vec3::Zero(), Mat3::Identity(), { 20.0, 4.0, 9.0 }), 0.0);
    }

} // namespace phantom_test
} // namespace retractor::datasets
