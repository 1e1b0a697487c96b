#include "datasets/segmentation/autosegment.h"

#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "datasets/segmentation/image/working_image.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <functional>
#include <limits>

namespace retractor::datasets {
namespace autosegment_test {

    // Finer grids give better numbers; these keep nine patients within some twenty seconds.
    constexpr double kTableSpacing = 2.0;
    constexpr double kTablePhantomSpacing = 2.5;
    // Of all other tests, which ask less.
    constexpr double kTestSpacing = 3.0;
    constexpr double kPhantomSpacing = 3.0;

    struct Shape {
        const char* name;
        ThoraxParameters parameters;
    };

    std::vector<Shape> shapes()
    {
        Shape slim { "slim", {} };
        slim.parameters.width_mm = 300.0;
        slim.parameters.depth_mm = 200.0;
        slim.parameters.fat_mm = 4.0;
        slim.parameters.muscle_mm = 7.0;
        Shape average { "average", {} };
        Shape large { "large", {} };
        large.parameters.width_mm = 410.0;
        large.parameters.depth_mm = 290.0;
        large.parameters.height_mm = 330.0;
        large.parameters.fat_mm = 26.0;
        large.parameters.muscle_mm = 13.0;
        for (Shape* shape : { &slim, &average, &large })
            shape->parameters.spacing_mm = Vec3::Constant(kPhantomSpacing);
        return { slim, average, large };
    }

    using Wanted = std::function<bool(const mesh::LabelInfo&)>;

    Wanted named(const std::string& start)
    {
        return [start](const mesh::LabelInfo& info) { return info.name.starts_with(start); };
    }

    Wanted any_label()
    {
        return [](const mesh::LabelInfo&) { return true; };
    }

    Wanted wall()
    {
        return [](const mesh::LabelInfo& info) { return info.role == mesh::Role::wall; };
    }

    Wanted bone()
    {
        return [](const mesh::LabelInfo& info) { return info.material == "bone"; };
    }

    std::vector<std::uint8_t> wanted_ids(const mesh::LabelTable& table, const Wanted& wanted)
    {
        std::vector<std::uint8_t> ids(65536, 0);
        for (const mesh::LabelInfo& info : table)
            ids[info.id] = wanted(info) ? 1 : 0;
        return ids;
    }

    /// 2 |A and B| / (|A| + |B|), both on one grid.
    double dice(const mesh::LabelVolume& truth, const mesh::LabelVolume& found, const Wanted& wanted)
    {
        const auto in_truth = wanted_ids(truth.table, wanted);
        const auto in_found = wanted_ids(found.table, wanted);
        double both = 0.0;
        double sum = 0.0;
        for (std::size_t v = 0; v < truth.voxels.size(); ++v) {
            both += in_truth[truth.voxels[v]] & in_found[found.voxels[v]];
            sum += in_truth[truth.voxels[v]] + in_found[found.voxels[v]];
        }
        return sum > 0.0 ? 2.0 * both / sum : 0.0;
    }

    double volume_ml(const mesh::LabelVolume& labels, const Wanted& wanted)
    {
        const auto ids = wanted_ids(labels.table, wanted);
        const auto count
            = std::count_if(labels.voxels.begin(), labels.voxels.end(), [&](Label label) { return ids[label] != 0; });
        return static_cast<double>(count) * labels.grid.voxel_volume() / 1000.0;
    }

    /// Of a label's voxels, mm.
    double highest_point(const mesh::LabelVolume& labels, Label label)
    {
        const auto slice
            = static_cast<std::size_t>(labels.grid.size[0]) * static_cast<std::size_t>(labels.grid.size[1]);
        for (std::size_t v = labels.voxels.size(); v-- > 0;)
            if (labels.voxels[v] == label)
                return labels.grid.origin.z() + labels.grid.spacing.z() * static_cast<double>(v / slice);
        return -std::numeric_limits<double>::infinity();
    }

    const Phantom& average_phantom()
    {
        static const Phantom phantom = make_thorax_phantom(shapes()[1].parameters);
        return phantom;
    }

    const Segmentation& average_segmentation()
    {
        static const Segmentation segmentation = autosegment(average_phantom().ct, { .spacing_mm = kTestSpacing });
        return segmentation;
    }

    template <typename Call> std::string message_of(const Call& call)
    {
        try {
            call();
        } catch (const InputError& error) {
            return error.what();
        }
        return "no error";
    }

    // The least overlap that is accepted; the same for all shapes, noises and grids.
    constexpr double kBody = 0.98;
    constexpr double kLungs = 0.97;
    constexpr double kWall = 0.95;
    constexpr double kBone = 0.85;

    void expect_agreement(const Shape& shape, double noise, double phantom_spacing, const AutosegmentOptions& options)
    {
        SCOPED_TRACE(shape.name + std::string(", noise ") + std::to_string(noise));
        ThoraxParameters parameters = shape.parameters;
        parameters.noise_hu = noise;
        parameters.spacing_mm = Vec3::Constant(phantom_spacing);
        const Phantom phantom = make_thorax_phantom(parameters);
        const Segmentation result = autosegment(phantom.ct, options);
        const mesh::LabelVolume found = resample_labels_to(result.labels, phantom.labels.grid);
        const double body = dice(phantom.labels, found, any_label());
        // Each by itself: swapped sides would agree where only both together are looked at.
        const double lungs = std::min(
            dice(phantom.labels, found, named("lung_left")), dice(phantom.labels, found, named("lung_right")));
        const double walls = dice(phantom.labels, found, wall());
        const double bones = dice(phantom.labels, found, bone());
        std::printf("%-8s %8.0f  %6.4f  %6.4f  %6.4f  %6.4f  %6.4f  %6.4f\n", shape.name, noise, body, lungs, walls,
            bones, dice(phantom.labels, found, named("heart")),
            dice(phantom.labels, found,
                [](const mesh::LabelInfo& info) { return info.name == "aorta" || info.name == "aneurysm"; }));
        EXPECT_GE(body, kBody);
        EXPECT_GE(lungs, kLungs);
        EXPECT_GE(walls, kWall);
        EXPECT_GE(bones, kBone);
    }

    TEST(Autosegment, AgreesWithThePhantomForEveryShapeAndNoise)
    {
        std::printf("shape    noise HU    body    lung    wall    bone   heart   aorta\n");
        for (const Shape& shape : shapes())
            for (const double noise : { 5.0, 40.0 })
                expect_agreement(shape, noise, kTablePhantomSpacing, { .spacing_mm = kTableSpacing });
    }

    TEST(Autosegment, AgreesWithThePhantomOnTheGridThatIsUsedInPractice)
    {
        const AutosegmentOptions as_shipped;
        ASSERT_EQ(as_shipped.spacing_mm, 1.5);
        expect_agreement(shapes()[1], 20.0, as_shipped.spacing_mm, as_shipped);
    }

    TEST(Autosegment, EveryVoxelOfTheBodyHasALabelOfTheTable)
    {
        const Segmentation& result = average_segmentation();
        mesh::check_grid(result.labels.grid);
        EXPECT_TRUE(result.labels.grid.direction.isIdentity());
        const auto known = wanted_ids(result.labels.table, any_label());
        const segmentation::WorkingImage image = segmentation::working_image(average_phantom().ct, kTestSpacing, 2);
        ASSERT_EQ(result.labels.voxels.size(), image.hu.size());
        std::size_t unlabelled = 0;
        for (std::size_t v = 0; v < image.hu.size(); ++v) {
            ASSERT_TRUE(result.labels.voxels[v] == 0 || known[result.labels.voxels[v]] != 0);
            // Tissue that is nothing would be a hole in the patient; a voxel of skin blurred with air may be lost.
            unlabelled += image.hu[v] > 0 && result.labels.voxels[v] == 0 ? 1 : 0;
        }
        EXPECT_LT(static_cast<double>(unlabelled), 1e-4 * static_cast<double>(image.hu.size()));
    }

    TEST(Autosegment, LeftIsLeft)
    {
        const mesh::LabelVolume& labels = average_segmentation().labels;
        for (const auto& [name, side] : { std::pair { "lung_left", 1.0 }, std::pair { "lung_right", -1.0 } }) {
            const Label id = mesh::find_label(labels.table, name)->id;
            double x = 0.0;
            double count = 0.0;
            for (std::size_t v = 0; v < labels.voxels.size(); ++v)
                if (labels.voxels[v] == id) {
                    x += labels.grid.origin.x()
                        + labels.grid.spacing.x()
                            * static_cast<double>(v % static_cast<std::size_t>(labels.grid.size[0]));
                    count += 1.0;
                }
            EXPECT_GT(side * x / count, 40.0) << name;
        }
    }

    TEST(Autosegment, TheWallIsClosed)
    {
        constexpr double kLeastWall = 4.0; // mm between what is inside and air
        const mesh::LabelVolume& labels = average_segmentation().labels;
        const segmentation::Extent extent { labels.grid.size,
            { labels.grid.spacing.x(), labels.grid.spacing.y(), labels.grid.spacing.z() } };
        segmentation::Mask outside(labels.voxels.size());
        segmentation::Mask inside(labels.voxels.size());
        const auto is_wall = wanted_ids(labels.table, wall());
        const Label trachea = mesh::find_label(labels.table, "trachea")->id; // it leaves the chest through the neck
        for (std::size_t v = 0; v < outside.size(); ++v) {
            const Label label = labels.voxels[v];
            outside[v] = label == 0 ? 1 : 0;
            inside[v] = label != 0 && label != trachea && is_wall[label] == 0 ? 1 : 0;
        }
        const std::vector<float> depth = segmentation::distance_to(extent, outside);
        float least = 1e9F;
        for (std::size_t v = 0; v < depth.size(); ++v)
            if (inside[v] != 0)
                least = std::min(least, depth[v]);
        EXPECT_GT(least, kLeastWall);
        EXPECT_EQ(segmentation::connected_pieces(extent, inside).voxels.size(), 1U);
    }

    TEST(Autosegment, EachStructureSaysHowItWasFound)
    {
        const Segmentation& result = average_segmentation();
        ASSERT_FALSE(result.structures.empty());
        double sum = 0.0;
        for (const FoundStructure& found : result.structures) {
            EXPECT_NE(mesh::find_label(result.labels.table, found.name), nullptr) << found.name;
            EXPECT_FALSE(found.how.empty()) << found.name;
            EXPECT_NEAR(found.volume_ml,
                volume_ml(result.labels, [&](const mesh::LabelInfo& info) { return info.name == found.name; }), 1e-6);
            sum += found.volume_ml;
        }
        EXPECT_EQ(result.structures.size(), result.labels.table.size());
        EXPECT_NEAR(sum, volume_ml(result.labels, any_label()), 1e-6);
    }

    TEST(Autosegment, SeesAContrastFilledAortaAndSaysWhenThereIsNone)
    {
        const auto aorta = [](const Segmentation& result) {
            return std::find_if(result.structures.begin(), result.structures.end(),
                [](const FoundStructure& found) { return found.name == "aorta"; });
        };
        const Segmentation& filled = average_segmentation();
        ASSERT_NE(aorta(filled), filled.structures.end());
        EXPECT_FALSE(aorta(filled)->rough);
        mesh::Volume plain = average_phantom().ct;
        const mesh::LabelTable& table = average_phantom().labels.table;
        for (std::size_t v = 0; v < plain.voxels.size(); ++v)
            if (const mesh::LabelInfo* info = mesh::find_label(table, average_phantom().labels.voxels[v]);
                info != nullptr && info->material != "bone" && plain.voxels[v] > 120)
                plain.voxels[v] = 45;
        const Segmentation without = autosegment(plain, { .spacing_mm = kTestSpacing });
        ASSERT_NE(aorta(without), without.structures.end());
        EXPECT_TRUE(aorta(without)->rough);
        EXPECT_TRUE(std::any_of(without.warnings.begin(), without.warnings.end(),
            [](const std::string& line) { return line.find("no contrast") != std::string::npos; }));
    }

    TEST(Autosegment, GivenLabelsAreKept)
    {
        const Phantom& phantom = average_phantom();
        // A heart and a tumour from elsewhere, on a grid of their own.
        mesh::LabelVolume given;
        given.grid = phantom.labels.grid;
        given.grid.spacing *= 1.5;
        for (int& size : given.grid.size)
            size = static_cast<int>(size / 1.5);
        given.table = { { 7, "heart", "heart", mesh::Role::at_risk }, { 9, "tumour", "vessel", mesh::Role::target } };
        given.voxels.assign(given.grid.voxel_count(), 0);
        std::size_t v = 0;
        for (int k = 0; k < given.grid.size[2]; ++k)
            for (int j = 0; j < given.grid.size[1]; ++j)
                for (int i = 0; i < given.grid.size[0]; ++i, ++v) {
                    const Vec3 p = given.grid.world(Vec3(i, j, k));
                    if ((p - Vec3(20.0, -20.0, -30.0)).norm() < 40.0)
                        given.voxels[v] = 7;
                    if ((p - Vec3(-80.0, 0.0, 20.0)).norm() < 15.0)
                        given.voxels[v] = 9;
                }
        AutosegmentOptions options { .spacing_mm = kTestSpacing };
        options.given = given;
        const Segmentation result = autosegment(phantom.ct, options);
        const mesh::LabelVolume back = resample_labels_to(given, result.labels.grid);
        const Label heart = mesh::find_label(result.labels.table, "heart")->id;
        const mesh::LabelInfo* tumour = mesh::find_label(result.labels.table, "tumour");
        ASSERT_NE(tumour, nullptr);
        EXPECT_EQ(tumour->role, mesh::Role::target);
        for (std::size_t n = 0; n < back.voxels.size(); ++n) {
            ASSERT_EQ(back.voxels[n] == 7, result.labels.voxels[n] == heart);
            ASSERT_EQ(back.voxels[n] == 9, result.labels.voxels[n] == tumour->id);
        }
        for (const FoundStructure& found : result.structures)
            if (found.name == "heart") {
                EXPECT_EQ(found.how, "given");
                EXPECT_FALSE(found.rough);
            }
    }

    TEST(Autosegment, TurnedAndMirroredAxesGiveTheSamePatient)
    {
        // The same voxels stored from the other ends: the world does not change.
        const mesh::Volume& ct = average_phantom().ct;
        mesh::Volume flipped = ct;
        flipped.grid.direction.col(0) *= -1.0;
        flipped.grid.direction.col(1) *= -1.0;
        flipped.grid.origin = ct.grid.world(Vec3(ct.grid.size[0] - 1, ct.grid.size[1] - 1, 0));
        for (int k = 0; k < ct.grid.size[2]; ++k)
            for (int j = 0; j < ct.grid.size[1]; ++j)
                for (int i = 0; i < ct.grid.size[0]; ++i)
                    flipped.voxels[ct.grid.offset(ct.grid.size[0] - 1 - i, ct.grid.size[1] - 1 - j, k)]
                        = ct.voxels[ct.grid.offset(i, j, k)];
        const Segmentation result = autosegment(flipped, { .spacing_mm = kTestSpacing });
        const mesh::LabelVolume found = resample_labels_to(result.labels, average_segmentation().labels.grid);
        constexpr double kRoundOff = 0.999; // an interpolated value may round to the other side
        EXPECT_GT(dice(average_segmentation().labels, found, named("lung_left")), kRoundOff);
        EXPECT_GT(dice(average_segmentation().labels, found, wall()), kRoundOff);
    }

    /// The phantom with planes of air on all sides. @param noise whether the air's value varies
    mesh::Volume padded_phantom(bool noise)
    {
        const mesh::Volume& ct = average_phantom().ct;
        constexpr int kPadding = 10; // planes
        mesh::Volume padded;
        padded.grid = ct.grid;
        for (int& size : padded.grid.size)
            size += 2 * kPadding;
        padded.grid.origin = ct.grid.world(Vec3::Constant(-kPadding));
        padded.voxels.assign(padded.grid.voxel_count(), segmentation::kOutsideHu);
        if (noise)
            for (std::size_t v = 0; v < padded.voxels.size(); v += 7)
                padded.voxels[v] = static_cast<std::int16_t>(segmentation::kOutsideHu + 10);
        for (int k = 0; k < ct.grid.size[2]; ++k)
            for (int j = 0; j < ct.grid.size[1]; ++j)
                for (int i = 0; i < ct.grid.size[0]; ++i)
                    padded.voxels[padded.grid.offset(i + kPadding, j + kPadding, k + kPadding)]
                        = ct.voxels[ct.grid.offset(i, j, k)];
        return padded;
    }

    TEST(Autosegment, EmptySlicesAtTheEndsChangeNothing)
    {
        // Images are padded so where they were moved onto others.
        const Segmentation result = autosegment(padded_phantom(false), { .spacing_mm = kTestSpacing });
        const mesh::LabelVolume found = resample_labels_to(result.labels, average_segmentation().labels.grid);
        constexpr double kNearly = 0.99; // the air beside the body may move a voxel at its rim
        for (const char* name : { "spine", "sternum", "rib_left_5", "rib_right_5", "lung_left", "skin" })
            EXPECT_GT(dice(average_segmentation().labels, found, named(name)), kNearly) << name;
        ASSERT_FALSE(result.warnings.empty());
        EXPECT_EQ(result.warnings.front(),
            "the image has 20 empty slices at its ends: they were left out, and the body is taken to go on there");
    }

    TEST(Autosegment, SpineAndRibsAreFoundBesideSlicesOfAir)
    {
        // Air that is not of one value may be all that is there, so the body is taken to end before it.
        const Segmentation result = autosegment(padded_phantom(true), { .spacing_mm = kTestSpacing });
        const mesh::LabelVolume found = resample_labels_to(result.labels, average_segmentation().labels.grid);
        constexpr double kMostly = 0.9; // the skin over the ends takes a layer of the bones there
        for (const char* name : { "spine", "sternum", "rib_left_5", "rib_right_5", "lung_left" })
            EXPECT_GT(dice(average_segmentation().labels, found, named(name)), kMostly) << name;
    }

    TEST(EmptyEnds, AnImageOfOneValueHasNone)
    {
        mesh::Volume ct;
        ct.grid.size = { 2, 3, 4 };
        ct.voxels.assign(ct.grid.voxel_count(), 0);
        const segmentation::EmptyEnds none = segmentation::empty_ends(ct);
        EXPECT_EQ(none.before + none.after, 0);
        ct.grid.direction.col(0).swap(ct.grid.direction.col(2)); // the first axis points to the head
        ct.voxels[ct.grid.offset(1, 2, 3)] = 5;
        const segmentation::EmptyEnds ends = segmentation::empty_ends(ct);
        EXPECT_EQ(ends.axis, 0);
        EXPECT_EQ(ends.before, 1);
        EXPECT_EQ(ends.after, 0);
        const mesh::Volume rest = segmentation::without(ct, ends);
        EXPECT_EQ(rest.grid.size, (std::array<int, 3> { 1, 3, 4 }));
        EXPECT_EQ(rest.voxels.back(), 5);
        EXPECT_EQ(rest.grid.world(Vec3::Zero()), ct.grid.world(Vec3(1, 0, 0)));
    }

    TEST(Autosegment, MetalOnTheSkinIsNoBone)
    {
        mesh::Volume ct = average_phantom().ct;
        const int i = ct.grid.size[0] / 3; // beside the sternum
        const int k = ct.grid.size[2] / 2;
        int skin = 0;
        while (average_phantom().labels.voxels[ct.grid.offset(i, skin, k)] == 0)
            ++skin;
        for (int dk = -2; dk <= 2; ++dk) // an electrode of 15 mm
            for (int di = -2; di <= 2; ++di)
                for (int j = skin - 1; j <= skin; ++j)
                    ct.voxels[ct.grid.offset(i + di, j, k + dk)] = 2500;
        const Segmentation result = autosegment(ct, { .spacing_mm = kTestSpacing });
        const mesh::LabelVolume found = resample_labels_to(result.labels, ct.grid);
        const mesh::LabelInfo* there = mesh::find_label(found.table, found.voxels[ct.grid.offset(i, skin, k)]);
        ASSERT_NE(there, nullptr);
        EXPECT_NE(there->material, "bone");
        EXPECT_TRUE(std::any_of(result.warnings.begin(), result.warnings.end(),
            [](const std::string& line) { return line.find("metal on the skin") != std::string::npos; }));
    }

    TEST(Autosegment, CancelsAndRecordsItsParts)
    {
        std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_TRUE(autosegment(average_phantom().ct, { .spacing_mm = 4.0 }, job).labels.voxels.empty());
        Ledger ledger;
        job = {};
        job.ledger = &ledger;
        static_cast<void>(autosegment(average_phantom().ct, { .spacing_mm = 4.0 }, job));
        EXPECT_TRUE(ledger.has("segmentation"));
        EXPECT_TRUE(ledger.has("labels"));
    }

    TEST(Autosegment, RefusesWhatShowsNoChest)
    {
        mesh::Volume air;
        air.grid.size = { 40, 40, 40 };
        air.grid.spacing = Vec3::Constant(5.0);
        air.voxels.assign(air.grid.voxel_count(), -1000);
        EXPECT_NE(message_of([&] { autosegment(air); }).find("no body was found"), std::string::npos);

        mesh::Volume tissue = air;
        tissue.voxels.assign(tissue.grid.voxel_count(), 40);
        EXPECT_NE(message_of([&] { autosegment(tissue); }).find("crop from inside the body"), std::string::npos);

        mesh::Volume trunk = air; // no lungs in it
        for (int k = 0; k < 40; ++k)
            for (int j = 8; j < 32; ++j)
                for (int i = 5; i < 35; ++i)
                    trunk.voxels[trunk.grid.offset(i, j, k)] = 40;
        EXPECT_NE(message_of([&] { autosegment(trunk); }).find("no lungs were found"), std::string::npos);

        EXPECT_NE(
            message_of([&] { autosegment(air, { .spacing_mm = 0.2 }); }).find("0.5 and 4, got 0.2"), std::string::npos);
        EXPECT_NE(message_of([&] { autosegment(air, { .spacing_mm = std::nan("") }); }).find("spacing_mm"),
            std::string::npos);
        mesh::Volume short_of_voxels = air;
        short_of_voxels.voxels.pop_back();
        EXPECT_NE(message_of([&] { autosegment(short_of_voxels); }).find("do not agree"), std::string::npos);
    }

    TEST(Autosegment, RefusesATurnedPlateWhoseBoxIsTooLarge)
    {
        mesh::Volume plate; // 600 ml, but its box along the world's axes holds half a cubic metre
        plate.grid.size = { 100, 100, 1 };
        plate.grid.spacing = { 10.0, 10.0, 0.6 };
        plate.grid.direction
            = Eigen::AngleAxisd(std::acos(1.0 / std::sqrt(3.0)), Vec3(-1.0, 1.0, 0.0).normalized()).toRotationMatrix();
        plate.voxels.assign(plate.grid.voxel_count(), 40);
        EXPECT_NE(message_of([&] { autosegment(plate); }).find("more than 120 million voxels"), std::string::npos);
        plate.grid.direction.setIdentity(); // the same voxels, straight: refused for another reason
        EXPECT_EQ(message_of([&] { autosegment(plate); }).find("million voxels"), std::string::npos);
    }

    TEST(ForPlanes, HandsOnTheFirstExceptionOfAnyThread)
    {
        for (const int threads : { 1, 4 }) {
            std::atomic<int> calls { 0 };
            EXPECT_THROW(segmentation::for_planes(1000, threads,
                             [&](int k) {
                                 ++calls;
                                 throw InputError("plane " + std::to_string(k), "test");
                             }),
                InputError);
            EXPECT_LE(calls, threads); // nobody went on after a failure
        }
    }

    TEST(AutosegmentRealData, ChestWithTableAndLeads)
    {
        const auto path = test_support::shared_data("ct/chest_half/ricord_chest_half.nii.gz");
        if (!std::filesystem::exists(path))
            GTEST_SKIP() << "no shared data: set RETRACTOR_SHARED_DATA";
        const mesh::Volume ct = read_volume(path);
        const Segmentation result = autosegment(ct, { .spacing_mm = kTestSpacing });
        // Rough thresholds that came with the image: 1 body, 2 lung and air, 3 bone above 180 HU.
        mesh::LabelVolume rough = read_label_voxels(test_support::shared_data("labels/ricord_half_hu_labels.nii.gz"));
        rough.table = { { 1, "body", "muscle", mesh::Role::wall }, { 2, "lung", "lung", mesh::Role::voxel },
            { 3, "bone", "bone", mesh::Role::wall } };
        const mesh::LabelVolume found = resample_labels_to(result.labels, rough.grid);
        EXPECT_GT(dice(rough, found, any_label()), 0.97);

        // Table, blankets and leads: what is no air and has nothing to do with the body that came with the image.
        constexpr double kClear = 10.0; // mm, so that nothing of the skin is counted
        constexpr int kChin = 3; // the uppermost slices show it, the labels that came with the image do not
        constexpr std::int16_t kNoAir = -500, kMetal = 500; // HU
        ASSERT_EQ(ct.voxels.size(), rough.voxels.size());
        const mesh::ImageGrid& grid = rough.grid;
        segmentation::Mask body(rough.voxels.size());
        std::transform(
            rough.voxels.begin(), rough.voxels.end(), body.begin(), [](Label label) { return label != 0 ? 1 : 0; });
        const segmentation::Mask near_body = segmentation::dilated(
            { grid.size, { grid.spacing.x(), grid.spacing.y(), grid.spacing.z() } }, body, kClear);
        const auto is_bone = wanted_ids(found.table, bone());
        std::size_t foreign = 0, labelled = 0, metal = 0, metal_as_bone = 0;
        for (std::size_t v = 0; v < grid.offset(0, 0, grid.size[2] - kChin); ++v) {
            if (ct.voxels[v] > kNoAir && near_body[v] == 0) {
                ++foreign;
                labelled += found.voxels[v] != 0 ? 1 : 0;
            }
            if (ct.voxels[v] > kMetal && body[v] == 0) {
                ++metal;
                metal_as_bone += is_bone[found.voxels[v]];
            }
        }
        EXPECT_GT(foreign, 1000U); // else nothing was looked at
        EXPECT_EQ(labelled, 0U);
        EXPECT_GT(metal, 10U);
        EXPECT_EQ(metal_as_bone, 0U);

        // A thin rib may be lost on this coarse grid; the others keep their order, and what is lost is told.
        constexpr int kLeastFound = 9; // of the ten upper ones
        for (const char* side : { "left", "right" }) {
            double above = std::numeric_limits<double>::infinity();
            int count = 0;
            for (int n = 1; n <= 10; ++n) {
                const std::string name = std::string("rib_") + side + "_" + std::to_string(n);
                const mesh::LabelInfo* info = mesh::find_label(result.labels.table, name);
                if (info == nullptr) {
                    EXPECT_TRUE(std::any_of(result.warnings.begin(), result.warnings.end(),
                        [&](const std::string& line) { return line.starts_with(name + " not found"); }))
                        << name;
                    continue;
                }
                ++count;
                const double z = highest_point(result.labels, info->id);
                EXPECT_LE(z, above) << name;
                above = z;
            }
            EXPECT_GE(count, kLeastFound) << side;
        }
    }

    TEST(AutosegmentRealData, CropsAndAbdomensAreRefused)
    {
        const auto crop = test_support::shared_data("ct/ts_thorax_cta/ct_aorta_crop.nii.gz");
        if (!std::filesystem::exists(crop))
            GTEST_SKIP() << "no shared data: set RETRACTOR_SHARED_DATA";
        EXPECT_NE(
            message_of([&] { autosegment(read_volume(crop)); }).find("crop from inside the body"), std::string::npos);
        const mesh::Volume abdomen = read_volume(test_support::shared_data("ct/ts_abdomen/example_ct.nii.gz"));
        EXPECT_NE(message_of([&] { autosegment(abdomen); }).find("no lungs were found"), std::string::npos);
    }

} // namespace autosegment_test
} // namespace retractor::datasets
