#include "datasets/phantoms/abdomen_phantom.h"

#include "datasets/phantoms/phantom_ct.h"
#include "datasets/phantoms/phantom_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor::datasets {

namespace {

    enum AbdomenLabel : Label { kWall = 1, kSpine, kLiver, kStomach, kBowel };

    void check(const AbdomenParameters& p)
    {
        check_parameter("width_mm", p.width_mm, 220.0, 420.0);
        check_parameter("depth_mm", p.depth_mm, 160.0, 320.0);
        check_parameter("height_mm", p.height_mm, 120.0, 300.0);
        check_parameter("wall_mm", p.wall_mm, 8.0, 40.0);
        for (const double spacing : p.spacing_mm)
            check_parameter("spacing_mm", spacing, 0.5, 6.0);
        check_parameter("margin_mm", p.margin_mm, 2.0, 100.0);
        check_parameter("noise_hu", p.noise_hu, 0.0, 100.0);
    }

    /// Signed distances of the organs. The shapes belong to an abdomen of 300 x 200 x 200 mm with a wall of 15 mm, and
    /// scale with the cavity.
    class Abdomen {
    public:
        explicit Abdomen(const AbdomenParameters& parameters)
            : half_(0.5 * parameters.width_mm, 0.5 * parameters.depth_mm, 0.5 * parameters.height_mm)
            , wall_(parameters.wall_mm)
            , scale_((half_.x() - wall_) / 135.0, (half_.y() - wall_) / 85.0, half_.z() / 100.0)
        {
            const std::array<Vec3, 5> corners { Vec3(28.0, 18.0, 92.0), Vec3(62.0, 8.0, 70.0), Vec3(76.0, -14.0, 30.0),
                Vec3(48.0, -36.0, -8.0), Vec3(6.0, -34.0, -14.0) };
            constexpr int kPieces = 6;
            const std::vector<Vec3> course = smooth_polyline(corners, kPieces);
            std::vector<double> radii;
            const Profile radius({ { 0.0, 9.0 }, { 0.15, 24.0 }, { 0.5, 30.0 }, { 0.8, 24.0 }, { 1.0, 13.0 } });
            for (std::size_t i = 0; i < course.size(); ++i)
                radii.push_back(radius(static_cast<double>(i) / static_cast<double>(course.size() - 1)));
            stomach_ = make_tube(course, radii);
        }

        /// First-order signed distance to the skin, an elliptic cylinder along z.
        double skin(const Vec3& p) const { return cylinder(p, half_.x(), half_.y()); }
        double cavity(const Vec3& p) const { return cylinder(p, half_.x() - wall_, half_.y() - wall_); }
        double spine(const Vec3& p) const
        {
            const double dx = p.x(), dy = p.y() - (half_.y() - wall_ - 8.0 * scale_.y());
            return std::hypot(dx, dy) - 21.0 * std::min(scale_.x(), scale_.y());
        }
        /// The liver lies against the wall on the right and in front, and is thin on the left.
        double liver(const Vec3& p) const
        {
            const Vec3 q = p.cwiseQuotient(scale_);
            const double right
                = ellipsoid_distance(q, Vec3(-68.0, 4.0, 30.0), Mat3::Identity(), Vec3(66.0, 74.0, 64.0));
            const double left = ellipsoid_distance(q, Vec3(4.0, -34.0, 52.0), Mat3::Identity(), Vec3(62.0, 46.0, 34.0));
            const double whole = smooth_min(right, left, 16.0);
            return std::max({ whole * scale_.minCoeff(), cavity(p), -spine(p) });
        }
        /// The stomach lies under the left lobe of the liver and touches the lobe.
        double stomach(const Vec3& p) const
        {
            const double free = tube_distance(stomach_, p.cwiseQuotient(scale_)) * scale_.minCoeff();
            return std::max({ free, -liver(p), cavity(p), -spine(p) });
        }
        Label label(const Vec3& p) const
        {
            if (skin(p) >= 0.0)
                return 0;
            if (spine(p) < 0.0)
                return kSpine;
            if (cavity(p) >= 0.0)
                return kWall;
            return liver(p) < 0.0 ? kLiver : stomach(p) < 0.0 ? kStomach : kBowel;
        }

    private:
        static double cylinder(const Vec3& p, double a, double b)
        {
            return ellipsoid_distance(Vec3(p.x(), p.y(), 0.0), Vec3::Zero(), Mat3::Identity(), Vec3(a, b, 1e6));
        }

        Vec3 half_;
        double wall_;
        Vec3 scale_;
        Tube stomach_;
    };

    float hu_of(Label label)
    {
        constexpr std::array<float, 6> kHu { -1000.0F, 20.0F, 350.0F, 100.0F, 30.0F, -40.0F };
        return kHu[label];
    }

    mesh::ImageGrid grid_of(const AbdomenParameters& p, double margin)
    {
        mesh::ImageGrid grid;
        grid.spacing = p.spacing_mm;
        const Vec3 extent(p.width_mm + 2.0 * margin, p.depth_mm + 2.0 * margin, p.height_mm);
        for (int axis = 0; axis < 3; ++axis)
            grid.size[static_cast<std::size_t>(axis)]
                = static_cast<int>(std::lround(extent[axis] / p.spacing_mm[axis]));
        grid.origin = -0.5 * grid.spacing.cwiseProduct(Vec3(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1));
        return grid;
    }

    Phantom filled(const mesh::ImageGrid& grid, const AbdomenParameters& parameters, mesh::LabelTable table,
        bool liver_alone, const Job& job)
    {
        const Stopwatch watch;
        const Abdomen abdomen(parameters);
        Phantom phantom;
        phantom.labels = { grid, std::vector<Label>(grid.voxel_count(), 0), std::move(table) };
        std::vector<float> hu(grid.voxel_count());
        for (int k = 0; k < grid.size[2]; ++k)
            for (int j = 0; j < grid.size[1]; ++j)
                for (int i = 0; i < grid.size[0]; ++i) {
                    const std::size_t v = grid.offset(i, j, k);
                    const Vec3 p = grid.world(Vec3(i, j, k));
                    const Label label
                        = !liver_alone ? abdomen.label(p) : static_cast<Label>(abdomen.liver(p) < 0.0 ? kLiver : 0);
                    phantom.labels.voxels[v] = label;
                    hu[v] = hu_of(label);
                }
        record_part(job, "labels", watch, phantom.labels.voxels.size() * sizeof(Label));
        const Stopwatch ct_watch;
        phantom.ct = render_ct(grid, hu, parameters.noise_hu, parameters.seed);
        record_part(job, "voxels", ct_watch, phantom.ct.voxels.size() * sizeof(std::int16_t));
        return phantom;
    }

} // namespace

Phantom make_abdomen_phantom(const AbdomenParameters& parameters, const Job& job)
{
    check(parameters);
    return filled(grid_of(parameters, parameters.margin_mm), parameters,
        { { kWall, "abdominal_wall", "muscle", mesh::Role::wall }, { kSpine, "spine", "bone", mesh::Role::wall },
            { kLiver, "liver", "liver", mesh::Role::voxel }, { kStomach, "stomach", "muscle", mesh::Role::voxel },
            { kBowel, "bowel", "fat", mesh::Role::voxel } },
        false, job);
}

Phantom make_liver_phantom(const AbdomenParameters& parameters, const Job& job)
{
    check(parameters);
    AbdomenParameters wide = parameters;
    wide.height_mm *= 1.2; // the grid then contains the whole height of the liver
    Phantom phantom = filled(grid_of(wide, 4.0 * parameters.spacing_mm.maxCoeff()), parameters,
        { { kLiver, "liver", "liver", mesh::Role::wall } }, true, job);
    return phantom;
}

} // namespace retractor::datasets
