#include "datasets/phantoms/abdomen_phantom.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

using namespace retractor;
using namespace retractor::datasets;

namespace abdomen_phantom_test {

AbdomenParameters coarse()
{
    AbdomenParameters parameters;
    parameters.spacing_mm = Vec3(4.0, 4.0, 4.0);
    return parameters;
}

double litres(const Phantom& phantom, Label label)
{
    std::size_t count = 0;
    for (const Label l : phantom.labels.voxels)
        count += l == label ? 1 : 0;
    return static_cast<double>(count) * phantom.labels.grid.spacing.prod() * 1e-6;
}

/// How many faces of voxels the two labels share.
std::size_t contact_faces(const mesh::LabelVolume& labels, Label a, Label b)
{
    const mesh::ImageGrid& grid = labels.grid;
    std::size_t faces = 0;
    for (int k = 0; k + 1 < grid.size[2]; ++k)
        for (int j = 0; j + 1 < grid.size[1]; ++j)
            for (int i = 0; i + 1 < grid.size[0]; ++i)
                for (const auto& [x, y, z] : { std::array { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }) {
                    const Label one = labels.voxels[grid.offset(i, j, k)],
                                other = labels.voxels[grid.offset(i + x, j + y, k + z)];
                    faces += (one == a && other == b) || (one == b && other == a) ? 1 : 0;
                }
    return faces;
}

TEST(AbdomenPhantom, hasOrgansOfHumanSizeThatTouch)
{
    const Phantom phantom = make_abdomen_phantom(coarse());
    EXPECT_GT(litres(phantom, 3), 0.9); // liver, 1 to 1.8 l in adults
    EXPECT_LT(litres(phantom, 3), 1.9);
    EXPECT_GT(litres(phantom, 4), 0.1); // stomach
    EXPECT_LT(litres(phantom, 4), 0.6);
    EXPECT_GT(contact_faces(phantom.labels, 1, 3), 100U); // wall and liver
    EXPECT_GT(contact_faces(phantom.labels, 3, 4), 30U); // liver and stomach
}

TEST(AbdomenPhantom, liverAloneIsTheSameLiver)
{
    const double whole = litres(make_abdomen_phantom(coarse()), 3), alone = litres(make_liver_phantom(coarse()), 3);
    EXPECT_GE(alone, 0.99 * whole); // it may go on beyond the imaged length
    EXPECT_LE(alone, 1.1 * whole);
    const Phantom liver = make_liver_phantom(coarse());
    const mesh::ImageGrid& grid = liver.labels.grid;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i)
                if (i == 0 || j == 0 || k == 0 || i == grid.size[0] - 1 || j == grid.size[1] - 1
                    || k == grid.size[2] - 1) {
                    ASSERT_EQ(liver.labels.voxels[grid.offset(i, j, k)], 0); // nowhere at the border
                }
}

TEST(AbdomenPhantom, namesWhatIsOutOfRange)
{
    AbdomenParameters parameters = coarse();
    parameters.wall_mm = std::nan("");
    try {
        make_abdomen_phantom(parameters);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()), "wall_mm must be between 8 and 40, got nan");
    }
}

} // namespace abdomen_phantom_test
