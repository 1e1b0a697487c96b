#include "datasets/segmentation/bones.h"

#include "datasets/phantom.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <string>

namespace retractor {

namespace {

    using namespace segmentation;

    // Coarse, so that nine patients take seconds; bones are segmented at 1.5 mm in practice, which only gets better.
    constexpr double kSpacing = 2.2; // mm

    struct Shape {
        const char* name;
        double width_mm, depth_mm, height_mm, fat_mm;
    };
    constexpr std::array<Shape, 3> kShapes { { { "average", 330.0, 225.0, 300.0, 8.0 },
        { "slender", 290.0, 205.0, 280.0, 4.0 }, { "large", 420.0, 290.0, 340.0, 24.0 } } };

    Phantom phantom(const Shape& shape, double noise_hu)
    {
        ThoraxParameters p;
        p.width_mm = shape.width_mm;
        p.depth_mm = shape.depth_mm;
        p.height_mm = shape.height_mm;
        p.fat_mm = shape.fat_mm;
        p.noise_hu = noise_hu;
        p.spacing_mm = Vec3::Constant(kSpacing);
        return make_thorax_phantom(p);
    }

    struct Masks {
        Mask body, lungs;
    };
    Masks true_masks(const LabelVolume& labels)
    {
        Masks masks { Mask(labels.voxels.size(), 0), Mask(labels.voxels.size(), 0) };
        for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
            const LabelInfo* info = labels.voxels[v] != 0 ? find_label(labels.table, labels.voxels[v]) : nullptr;
            masks.body[v] = info != nullptr;
            masks.lungs[v] = info != nullptr && (info->name.starts_with("lung_") || info->name == "trachea");
        }
        return masks;
    }

    /// Overlap of what is found with what is true, by name.
    struct Overlap {
        double found = 0.0, truth = 0.0, both = 0.0;
        double dice() const { return found + truth > 0.0 ? 2.0 * both / (found + truth) : 1.0; }
    };
    bool is_bone(const std::string& name) { return !name.empty() && name != "costal_cartilages"; }

    std::map<std::string, Overlap> overlaps(const Bones& bones, const LabelVolume& truth)
    {
        std::map<Label, std::string> found_name, true_name;
        for (const LabelInfo& info : bones.table)
            found_name[info.id] = info.name;
        for (const LabelInfo& info : truth.table)
            if (info.material == "bone" || info.name == "costal_cartilages")
                true_name[info.id] = info.name;
        std::map<std::string, Overlap> result;
        Overlap& all = result["all bone"];
        for (std::size_t v = 0; v < truth.voxels.size(); ++v) {
            const std::string& found = found_name[bones.labels[v]];
            const std::string& real = true_name[truth.voxels[v]];
            all.found += is_bone(found);
            all.truth += is_bone(real);
            all.both += is_bone(found) && is_bone(real);
            if (!found.empty())
                result[found].found += 1.0;
            if (!real.empty())
                result[real].truth += 1.0;
            if (!found.empty() && found == real)
                result[found].both += 1.0;
        }
        return result;
    }

    Bones segment(const Phantom& phantom, const Job& job = {})
    {
        const WorkingImage image { phantom.ct.grid, phantom.ct.voxels };
        const Masks masks = true_masks(phantom.labels);
        return segment_bones({ image, masks.body, masks.lungs, nullptr }, job);
    }

    class PhantomBones : public testing::TestWithParam<std::pair<int, double>> { };

} // namespace

TEST_P(PhantomBones, EveryBoneIsFoundUnderItsName)
{
    const Shape& shape = kShapes[static_cast<std::size_t>(GetParam().first)];
    const Phantom patient = phantom(shape, GetParam().second);
    const Bones bones = segment(patient);
    auto overlap = overlaps(bones, patient.labels);

    constexpr double kAllBone = 0.85, kRib = 0.7; // what planning needs: an incision beside the right rib
    double worst = 1.0;
    for (const char* side : { "left", "right" })
        for (int n = 1; n <= 12; ++n) {
            const std::string name = std::string("rib_") + side + "_" + std::to_string(n);
            EXPECT_GE(overlap[name].dice(), kRib) << name;
            worst = std::min(worst, overlap[name].dice());
        }
    EXPECT_GE(overlap["all bone"].dice(), kAllBone);
    std::printf("%-8s noise %2.0f HU: bone %.3f, worst rib %.3f, sternum %.3f, spine %.3f, scapulae %.3f %.3f, "
                "clavicles %.3f %.3f\n",
        shape.name, GetParam().second, overlap["all bone"].dice(), worst, overlap["sternum"].dice(),
        overlap["spine"].dice(), overlap["scapula_left"].dice(), overlap["scapula_right"].dice(),
        overlap["clavicle_left"].dice(), overlap["clavicle_right"].dice());
}

INSTANTIATE_TEST_SUITE_P(ShapesAndNoise, PhantomBones,
    testing::Values(std::pair(0, 5.0), std::pair(0, 20.0), std::pair(0, 40.0), std::pair(1, 5.0), std::pair(1, 20.0),
        std::pair(1, 40.0), std::pair(2, 5.0), std::pair(2, 20.0), std::pair(2, 40.0)));

} // namespace retractor
