#include "datasets/phantoms/phantom.h"

#include "datasets/phantoms/phantom_ct.h"
#include "datasets/phantoms/thorax_anatomy.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace retractor::datasets {

namespace {

    void check(const ThoraxParameters& p)
    {
        check_parameter("width_mm", p.width_mm, 260.0, 460.0);
        check_parameter("depth_mm", p.depth_mm, 190.0, 330.0);
        check_parameter("height_mm", p.height_mm, 240.0, 380.0);
        for (const double spacing : p.spacing_mm)
            check_parameter("spacing_mm", spacing, 0.5, 6.0);
        check_parameter("margin_mm", p.margin_mm, 2.0, 100.0);
        if (p.field_of_view_mm != 0.0)
            check_parameter(
                "field_of_view_mm", p.field_of_view_mm, std::max(p.width_mm, p.depth_mm) + 2.0 * p.margin_mm, 700.0);
        check_parameter("skin_mm", p.skin_mm, 1.0, 6.0);
        check_parameter("fat_mm", p.fat_mm, 3.0, 40.0);
        check_parameter("muscle_mm", p.muscle_mm, 5.0, 25.0);
        check_parameter("aneurysm_diameter_mm", p.aneurysm_diameter_mm, 30.0, 70.0);
        check_parameter("noise_hu", p.noise_hu, 0.0, 100.0);
    }

    /// The ids of the labels, in the order of the table.
    struct Ids {
        Label skin, fat, muscle, intercostal;
        std::array<std::array<Label, kRibPairs>, 2> rib; ///< [0] left, [1] right
        Label costal_cartilages, sternum, spine;
        std::array<Label, 2> scapula, clavicle, lung;
        Label heart, pericardium, aorta, aneurysm, coronary_target, mediastinal_fat;
        Label pulmonary_artery, vena_cava, trachea, oesophagus, diaphragm, liver, stomach;
    };

    struct NamedLabels {
        Ids id {};
        mesh::LabelTable table;
    };

    NamedLabels name_labels()
    {
        NamedLabels n;
        const auto add = [&](const std::string& name, const char* material, mesh::Role role) {
            const auto id = static_cast<Label>(n.table.size() + 1);
            n.table.push_back({ id, name, material, role });
            return id;
        };
        const std::array<std::string, 2> sides { "left", "right" };
        Ids& id = n.id;
        id.skin = add("skin", "skin", mesh::Role::wall);
        id.fat = add("fat", "fat", mesh::Role::wall);
        id.muscle = add("muscle", "muscle", mesh::Role::wall);
        id.intercostal = add("intercostal", "intercostal", mesh::Role::wall);
        for (std::size_t side = 0; side < 2; ++side)
            for (std::size_t rib = 0; rib < kRibPairs; ++rib)
                id.rib[side][rib] = add("rib_" + sides[side] + "_" + std::to_string(rib + 1), "bone", mesh::Role::wall);
        id.costal_cartilages = add("costal_cartilages", "cartilage", mesh::Role::wall);
        id.sternum = add("sternum", "bone", mesh::Role::wall);
        id.spine = add("spine", "bone", mesh::Role::wall);
        for (std::size_t side = 0; side < 2; ++side)
            id.scapula[side] = add("scapula_" + sides[side], "bone", mesh::Role::wall);
        for (std::size_t side = 0; side < 2; ++side)
            id.clavicle[side] = add("clavicle_" + sides[side], "bone", mesh::Role::wall);
        for (std::size_t side = 0; side < 2; ++side)
            id.lung[side] = add("lung_" + sides[side], "lung", mesh::Role::voxel);
        id.heart = add("heart", "heart", mesh::Role::at_risk);
        id.pericardium = add("pericardium", "heart", mesh::Role::voxel);
        id.aorta = add("aorta", "vessel", mesh::Role::at_risk);
        id.aneurysm = add("aneurysm", "vessel", mesh::Role::target);
        id.coronary_target = add("coronary_target", "vessel", mesh::Role::target);
        id.mediastinal_fat = add("mediastinal_fat", "fat", mesh::Role::voxel);
        id.pulmonary_artery = add("pulmonary_artery", "vessel", mesh::Role::at_risk);
        id.vena_cava = add("vena_cava", "vessel", mesh::Role::at_risk);
        id.trachea = add("trachea", "cartilage", mesh::Role::voxel);
        id.oesophagus = add("oesophagus", "muscle", mesh::Role::voxel);
        id.diaphragm = add("diaphragm", "muscle", mesh::Role::voxel);
        id.liver = add("liver", "liver", mesh::Role::voxel);
        id.stomach = add("stomach", "muscle", mesh::Role::voxel);
        return n;
    }

    constexpr double kAir = -1000.0;
    constexpr double kCortex = 850.0;
    constexpr double kMarrow = 320.0;

    /// Paints the labels and ideal Hounsfield values of the phantom, structure by structure.
    class Painter {
    public:
        Painter(const ThoraxParameters& parameters, const Job& job)
            : parameters_(parameters)
            , job_(job)
            , surfaces_(parameters)
            , organs_(parameters, surfaces_)
            , names_(name_labels())
            , id_(names_.id)
        {
            lay_out_grid();
            labels_.assign(grid_.voxel_count(), 0);
            hu_.assign(grid_.voxel_count(), static_cast<float>(kAir));
        }

        Phantom paint()
        {
            const Stopwatch watch;
            const std::array<void (Painter::*)(), 6> stages { &Painter::fill_distances, &Painter::paint_layers,
                &Painter::paint_girdle, &Painter::paint_front, &Painter::paint_ribs, &Painter::paint_cavity };
            for (std::size_t stage = 0; stage < stages.size(); ++stage) {
                job_.report("phantom", static_cast<double>(stage) / (stages.size() + 1));
                if (job_.cancelled())
                    return {};
                (this->*stages[stage])();
            }
            Phantom phantom;
            phantom.labels = { grid_, std::move(labels_), std::move(names_.table) };
            record_part(job_, "labels", watch, phantom.labels.voxels.size() * sizeof(Label));
            const Stopwatch ct_watch;
            phantom.ct = render_ct(grid_, hu_, parameters_.noise_hu, parameters_.seed);
            record_part(job_, "voxels", ct_watch, phantom.ct.voxels.size() * sizeof(std::int16_t));
            job_.report("phantom", 1.0);
            return phantom;
        }

    private:
        void lay_out_grid();
        void fill_distances();
        void paint_layers();
        void paint_girdle();
        void paint_scapula_voxel(std::size_t v, const Vec3& p, double angle);
        void paint_front();
        void paint_ribs();
        void paint_cavity();
        void paint_cavity_voxel(std::size_t v, const Vec3& p);

        template <typename Visit> void visit_box(const Vec3& low, const Vec3& high, const Visit& visit);
        void set(std::size_t v, Label label, double hu)
        {
            labels_[v] = label;
            hu_[v] = static_cast<float>(hu);
        }
        bool soft_wall(std::size_t v) const { return labels_[v] == id_.muscle || labels_[v] == id_.intercostal; }

        const ThoraxParameters& parameters_;
        const Job& job_;
        ThoraxSurfaces surfaces_;
        ThoraxOrgans organs_;
        NamedLabels names_;
        Ids& id_;
        mesh::ImageGrid grid_;
        std::vector<Label> labels_;
        std::vector<float> hu_;
        std::vector<float> depth_; ///< depth under the skin, mm
        std::vector<float> outward_; ///< distance outside the inner side of the rib cage, mm
    };

    void Painter::lay_out_grid()
    {
        const double view = parameters_.field_of_view_mm;
        const Vec3 extent(view > 0.0 ? view : parameters_.width_mm + 2.0 * parameters_.margin_mm,
            view > 0.0 ? view : parameters_.depth_mm + 2.0 * parameters_.margin_mm, parameters_.height_mm);
        for (int axis = 0; axis < 3; ++axis)
            grid_.size[static_cast<std::size_t>(axis)]
                = static_cast<int>(std::lround(extent[axis] / parameters_.spacing_mm[axis]));
        constexpr std::size_t kMostVoxels = 400'000'000; // 6 GB of working memory
        if (grid_.voxel_count() > kMostVoxels)
            throw InputError("the phantom would have more than 400 million voxels: use a larger spacing", "spacing_mm");
        grid_.spacing = parameters_.spacing_mm;
        for (int axis = 0; axis < 3; ++axis)
            grid_.origin[axis] = -0.5 * grid_.spacing[axis] * (grid_.size[static_cast<std::size_t>(axis)] - 1);
    }

    template <typename Visit> void Painter::visit_box(const Vec3& low, const Vec3& high, const Visit& visit)
    {
        const Vec3 first = grid_.index(low);
        const Vec3 last = grid_.index(high);
        std::array<int, 3> begin {};
        std::array<int, 3> end {};
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            begin[a] = std::max(0, static_cast<int>(std::floor(first[axis])));
            end[a] = std::min(grid_.size[a], static_cast<int>(std::ceil(last[axis])) + 1);
        }
        for (int k = begin[2]; k < end[2]; ++k)
            for (int j = begin[1]; j < end[1]; ++j)
                for (int i = begin[0]; i < end[0]; ++i)
                    visit(grid_.offset(i, j, k), grid_.world(Vec3(i, j, k)));
    }

    /// Computes a field of first-order distances: level sets on the grid, divided by their gradient. The powers of x
    /// and y are computed once per slice, so that only one power per voxel remains.
    template <typename SectionAt> std::vector<float> distances(const mesh::ImageGrid& grid, const SectionAt& section_at)
    {
        const auto nx = static_cast<std::size_t>(grid.size[0]);
        const auto ny = static_cast<std::size_t>(grid.size[1]);
        const auto slice_size = nx * ny;
        const auto level_slice = [&](int k, std::vector<double>& out) {
            const ThoraxSurfaces::Section s = section_at(grid.origin.z() + grid.spacing.z() * k);
            std::vector<double> px(nx);
            for (std::size_t i = 0; i < nx; ++i)
                px[i] = std::pow(
                    std::abs(grid.origin.x() + grid.spacing.x() * static_cast<double>(i)) / s.half_width, kSquareness);
            for (std::size_t j = 0; j < ny; ++j) {
                const double y = grid.origin.y() + grid.spacing.y() * static_cast<double>(j) - s.centre_y;
                const double py = std::pow(std::abs(y) / s.half_depth, kSquareness);
                for (std::size_t i = 0; i < nx; ++i)
                    out[j * nx + i] = std::sqrt(std::pow(px[i] + py, 2.0 / kSquareness) + s.dome) - 1.0;
            }
        };
        std::vector<float> field(grid.voxel_count());
        std::vector<double> below(slice_size);
        std::vector<double> here(slice_size);
        std::vector<double> above(slice_size);
        level_slice(-1, below);
        level_slice(0, here);
        for (int k = 0; k < grid.size[2]; ++k) {
            level_slice(k + 1, above);
            for (std::size_t j = 0; j < ny; ++j)
                for (std::size_t i = 0; i < nx; ++i) {
                    const std::size_t at = j * nx + i;
                    const auto slope = [&](std::size_t low, std::size_t high, double h) {
                        return (here[high] - here[low]) / (static_cast<double>(high - low) * h);
                    };
                    const double gx = slope(i > 0 ? at - 1 : at, i + 1 < nx ? at + 1 : at, grid.spacing.x());
                    const std::size_t south = j > 0 ? at - nx : at;
                    const std::size_t north = j + 1 < ny ? at + nx : at;
                    const double gy
                        = (here[north] - here[south]) / (static_cast<double>((north - south) / nx) * grid.spacing.y());
                    const double gz = (above[at] - below[at]) / (2.0 * grid.spacing.z());
                    field[static_cast<std::size_t>(k) * slice_size + at]
                        = static_cast<float>(here[at] / std::max(std::sqrt(gx * gx + gy * gy + gz * gz), 1e-9));
                }
            std::swap(below, here);
            std::swap(here, above);
        }
        return field;
    }

    void Painter::fill_distances()
    {
        depth_ = distances(grid_, [this](double z) { return surfaces_.body_section(z); });
        for (float& d : depth_)
            d = -d;
        outward_ = distances(grid_, [this](double z) { return surfaces_.cage_section(z); });
    }

    /// Paints skin, fat, muscle, the intercostal shell, and the spine with its cover.
    void Painter::paint_layers()
    {
        constexpr double kLeastMuscle = 2.5; // muscle between fat and rib cage at any thickness of the fat
        constexpr double kSpineCover = 3.0; // soft tissue over the vertebral bodies
        constexpr double kSpineReach = 45.0; // half the width of the spine and its processes, nominal
        const std::size_t nx = static_cast<std::size_t>(grid_.size[0]);
        std::size_t v = 0;
        for (int k = 0; k < grid_.size[2]; ++k)
            for (int j = 0; j < grid_.size[1]; ++j)
                for (std::size_t i = 0; i < nx; ++i, ++v) {
                    const double depth = depth_[v];
                    if (depth <= 0.0)
                        continue;
                    const double outward = outward_[v];
                    const Vec3 p = grid_.world(Vec3(static_cast<double>(i), j, k));
                    const double z = p.z() / surfaces_.height_scale();
                    const double front = smooth_step(20.0, -60.0, p.y());
                    // The fat is thin over the sternum and thick over the belly.
                    const double fat = parameters_.fat_mm
                        * (1.0 + 0.45 * front * smooth_step(-60.0, -150.0, z)
                            - 0.35 * front * std::exp(-p.x() * p.x() / 900.0) * smooth_step(-110.0, -60.0, z));
                    if (depth < parameters_.skin_mm)
                        set(v, id_.skin, 40.0);
                    else if (outward < kShell)
                        set(v, id_.intercostal, 25.0); // later steps paint the inside
                    else if (depth < parameters_.skin_mm + fat && outward > kShell + kLeastMuscle)
                        set(v, id_.fat, -100.0);
                    else
                        set(v, id_.muscle, 50.0);
                    const Vec3 n = surfaces_.nominal(p);
                    if (std::abs(n.x()) > kSpineReach || n.y() < 0.0)
                        continue;
                    const double spine = spine_distance(n) * surfaces_.scale();
                    if (spine < 0.0 && labels_[v] != id_.skin && labels_[v] != id_.fat)
                        set(v, id_.spine, in_disc(n) ? 90.0 : spine > -2.0 ? 0.8 * kCortex : 240.0);
                    else if (outward < 0.0 && spine >= kSpineCover)
                        labels_[v] = 0;
                }
        // The organs fill the space inside the cage that is neither spine nor cover of the spine.
        for (std::size_t at = 0; at < labels_.size(); ++at)
            if (labels_[at] == id_.intercostal && outward_[at] < 0.0F) {
                const auto i = static_cast<double>(at % nx);
                const auto j = static_cast<double>((at / nx) % static_cast<std::size_t>(grid_.size[1]));
                const auto k = static_cast<double>(at / (nx * static_cast<std::size_t>(grid_.size[1])));
                const Vec3 n = surfaces_.nominal(grid_.world({ i, j, k }));
                if (std::abs(n.x()) > kSpineReach || n.y() < 0.0)
                    labels_[at] = 0;
            }
    }

    /// Paints the shoulder girdle: scapulae and clavicles, inside the muscle.
    void Painter::paint_girdle()
    {
        const double h = surfaces_.height_scale();
        const Vec3 low(grid_.world(Vec3::Zero()).x(), -10.0, -50.0 * h);
        const Vec3 high(-low.x(), 0.5 * parameters_.depth_mm, 110.0 * h);
        visit_box(low, high, [&](std::size_t v, const Vec3& p) {
            if (labels_[v] == id_.muscle)
                paint_scapula_voxel(v, p, surfaces_.cage_angle(p));
        });

        const double reach = 0.36 * parameters_.width_mm; // acromial end
        for (std::size_t side = 0; side < 2; ++side) {
            std::vector<Vec3> corners;
            for (int i = 0; i <= 6; ++i) {
                const double t = i / 6.0;
                const double x = 22.0 + (reach - 22.0) * t;
                const double depth
                    = parameters_.skin_mm + parameters_.fat_mm + 8.0 + 5.0 * std::sin(2.0 * std::numbers::pi * t);
                Vec3 p = surfaces_.under_front_skin(x, (90.0 + 17.0 * t) * h, depth);
                p.x() *= side == 0 ? 1.0 : -1.0;
                corners.push_back(p);
            }
            const Tube bone = make_tube(smooth_polyline(corners, 4), std::vector<double>(6 * 4 + 1, 6.0));
            const double far = std::max(std::abs(corners.front().x()), reach) + 8.0;
            const double near = 12.0;
            visit_box({ side == 0 ? near : -far, -0.6 * parameters_.depth_mm, 75.0 * h },
                { side == 0 ? far : -near, 0.3 * parameters_.depth_mm, 120.0 * h }, [&](std::size_t v, const Vec3& p) {
                    if (!soft_wall(v) || outward_[v] < kPleuralCover)
                        return;
                    const double d = tube_distance(bone, p);
                    if (d < 0.0)
                        set(v, id_.clavicle[side], d > -2.0 ? kCortex : kMarrow);
                });
        }
    }

    void Painter::paint_scapula_voxel(std::size_t v, const Vec3& p, double angle)
    {
        // The blade lies on the back of the rib cage: u runs along the cage (mm from the midline), z is the nominal
        // height.
        constexpr double kBladeOutward = kShell + 7.0; // leaves a layer of subscapular muscle under the blade
        constexpr double kBladeHalf = 3.2;
        constexpr double kSpineHeight = 13.0; // height of the scapular spine over the blade
        const double u = 110.0 * angle * surfaces_.scale();
        const double z = p.z() / surfaces_.height_scale();
        const double outward = outward_[v];
        if (outward < kShell + 2.0 || outward > kBladeOutward + 18.0 || u < 40.0 || u > 190.0)
            return;
        const Eigen::Vector2d q(u, z);
        const double blade
            = triangle_distance(q, { Eigen::Vector2d(62.0, 78.0), { 82.0, -24.0 }, { 146.0, 66.0 } }) - 5.0;
        const double off = std::abs(outward - kBladeOutward) - kBladeHalf;
        double d = std::max(blade, off);
        // Glenoid and neck; then the spine of the scapula, which rises to the acromion.
        const Vec3 flat(u, z, outward - kBladeOutward);
        d = smooth_min(d, (flat - Vec3(150.0, 70.0, 2.0)).norm() - 11.0, 5.0);
        const Nearest ridge = nearest_on_segment({ u, z, 0.0 }, { 66.0, 56.0, 0.0 }, { 160.0, 90.0, 0.0 });
        const double along = std::clamp((ridge.point.x() - 66.0) / 94.0, 0.0, 1.0);
        const double height = kSpineHeight * smooth_step(0.0, 0.7, along);
        d = std::min(d, std::max(ridge.distance - 3.5, std::abs(flat.z() - 0.5 * height) - 0.5 * height));
        if (d < 0.0)
            set(v, id_.scapula[p.x() > 0.0 ? 0 : 1], d > -1.6 ? kCortex : kMarrow);
    }

    /// Paints the sternum, a rounded plate in the front of the shell.
    void Painter::paint_front()
    {
        constexpr double kInner = kPleuralCover;
        constexpr double kThickness = 10.0;
        const double h = surfaces_.height_scale();
        const double kx = surfaces_.world({ 1.0, 0.0, 0.0 }).x();
        visit_box({ -36.0 * kx, -0.6 * parameters_.depth_mm, -90.0 * h }, { 36.0 * kx, 0.0, 98.0 * h },
            [&](std::size_t v, const Vec3& p) {
                const double notch = 6.0 * std::exp(-p.x() * p.x() / 200.0); // jugular notch
                const double z = p.z() / h;
                const double half = kx * sternum_half_width(z > 60.0 ? z + notch : z);
                if (!soft_wall(v) || half <= 0.0)
                    return;
                const double across = std::abs(p.x()) / half;
                const double through = (outward_[v] - (kInner + 0.5 * kThickness)) / (0.5 * kThickness);
                const double g = std::pow(across, 6.0) + std::pow(through, 4.0);
                if (g < 1.0)
                    set(v, id_.sternum, g > 0.35 ? 0.7 * kCortex : 250.0);
            });
    }

    /// Paints ribs and cartilages as bands around a centreline, thin across the wall and high along the wall.
    void Painter::paint_ribs()
    {
        constexpr double kCartilageHeight = 11.0;
        constexpr double kJointGap = 2.5; // soft tissue between a rib's head and the spine
        const auto band = [&](const std::vector<Vec3>& course, double height, const auto& paint) {
            const double reach = 0.5 * std::max(height, kRibThickness) + 1.0;
            for (std::size_t s = 0; s + 1 < course.size(); ++s)
                visit_box(course[s].cwiseMin(course[s + 1]).array() - reach,
                    course[s].cwiseMax(course[s + 1]).array() + reach, [&](std::size_t v, const Vec3& p) {
                        const double across = outward_[v] - kRibMiddle;
                        if (std::abs(across) > 0.5 * kRibThickness)
                            return;
                        const double d = nearest_on_segment(p, course[s], course[s + 1]).distance;
                        const double along = std::sqrt(std::max(0.0, d * d - across * across));
                        const double g = std::pow(std::abs(across) / (0.5 * kRibThickness), 3.0)
                            + std::pow(along / (0.5 * height), 3.0);
                        if (g < 1.0)
                            paint(v, p, g);
                    });
        };
        for (std::size_t side = 0; side < 2; ++side) {
            const auto courses = rib_courses(surfaces_, side == 0 ? 1.0 : -1.0);
            for (std::size_t rib = 0; rib < courses.size(); ++rib) {
                const Label label = id_.rib[side][rib];
                band(courses[rib].bone, kRibHeight, [&](std::size_t v, const Vec3& p, double g) {
                    if (labels_[v] == label) {
                        // Marrow as seen from another piece of the rib.
                        hu_[v] = g > 0.4 ? hu_[v] : static_cast<float>(kMarrow);
                        return;
                    }
                    if (soft_wall(v) && spine_distance(surfaces_.nominal(p)) * surfaces_.scale() > kJointGap)
                        set(v, label, g > 0.4 ? kCortex : kMarrow);
                });
            }
            for (const RibCourse& course : courses)
                if (!course.cartilage.empty())
                    band(course.cartilage, kCartilageHeight, [&](std::size_t v, const Vec3&, double) {
                        if (soft_wall(v))
                            set(v, id_.costal_cartilages, 110.0);
                    });
        }
    }

    void Painter::paint_cavity()
    {
        std::size_t v = 0;
        for (int k = 0; k < grid_.size[2]; ++k)
            for (int j = 0; j < grid_.size[1]; ++j)
                for (int i = 0; i < grid_.size[0]; ++i, ++v)
                    if (labels_[v] == 0 && depth_[v] > 0.0F)
                        paint_cavity_voxel(v, grid_.world(Vec3(i, j, k)));
        // The windpipe leaves the chest through the wall and runs up the neck.
        const double h = surfaces_.height_scale();
        visit_box({ -20.0, -40.0, 80.0 * h }, { 20.0, 60.0, 0.5 * parameters_.height_mm },
            [&](std::size_t at, const Vec3& p) {
                if (soft_wall(at) && tube_distance(organs_.trachea.front(), surfaces_.nominal(p)) < 0.0)
                    set(at, id_.trachea, kAir);
            });
    }

    void Painter::paint_cavity_voxel(std::size_t v, const Vec3& p)
    {
        constexpr double kPericardium = 3.0;
        constexpr double kDiaphragm = 4.0;
        constexpr double kSheath = 4.0; // fat around the organs of the mediastinum
        constexpr double kMediastinumReach = 105.0; // nominal half-width of the space that contains these organs
        const Vec3 n = surfaces_.nominal(p);
        double sheath = std::numeric_limits<double>::infinity();
        if (std::abs(n.x()) < kMediastinumReach) {
            const auto inside = [&](double distance) {
                sheath = std::min(sheath, distance);
                return distance < 0.0;
            };
            const auto inside_any = [&](const std::vector<Tube>& tubes) {
                bool any = false;
                for (const Tube& tube : tubes)
                    any = inside(tube_distance(tube, n)) || any;
                return any;
            };
            const double aneurysm = organs_.aneurysm(n);
            const double aorta = tube_distance(organs_.aorta, n);
            if (inside(aneurysm))
                return set(v, id_.aneurysm, 350.0);
            if (inside(smooth_min(aorta, aneurysm, 8.0)) || inside_any(organs_.arch_branches))
                return set(v, id_.aorta, 350.0);
            const double coronary = organs_.coronary_target(n);
            const double heart = organs_.heart(n);
            if (inside(coronary))
                return set(v, id_.coronary_target, 330.0);
            if (inside(heart))
                return set(v, id_.heart, heart > -7.0 ? 110.0 : 200.0); // muscle of the heart, blood
            if (inside_any(organs_.pulmonary_artery))
                return set(v, id_.pulmonary_artery, 260.0);
            if (inside(tube_distance(organs_.vena_cava, n)))
                return set(v, id_.vena_cava, 220.0);
            if (inside(smooth_min(heart, coronary, 6.0) - kPericardium))
                return set(v, id_.pericardium, 30.0);
            if (inside_any(organs_.trachea))
                return set(v, id_.trachea, kAir);
            if (inside(tube_distance(organs_.oesophagus, n)))
                return set(v, id_.oesophagus, 35.0);
        }
        const double under_diaphragm = ThoraxOrgans::diaphragm_height(n.x(), n.y()) - n.z();
        if (under_diaphragm > kDiaphragm)
            return n.x() < 34.0 - 0.25 * (n.z() + 100.0) ? set(v, id_.liver, 105.0) : set(v, id_.stomach, 20.0);
        if (under_diaphragm > 0.0)
            return set(v, id_.diaphragm, 50.0);
        // The tissue between the lungs is a sheet from sternum to spine, thin in front, and thicker around the organs.
        const double sheet = std::abs(n.x() - 3.0) - (6.0 + 12.0 * smooth_step(-45.0, 45.0, n.y()));
        if (smooth_min(sheath - kSheath, sheet, 10.0) < 0.0)
            return set(v, id_.mediastinal_fat, -95.0);
        // Blood collects in the back of a supine patient, so the lung is denser there.
        set(v, id_.lung[n.x() > 3.0 ? 0 : 1], -860.0 + 40.0 * smooth_step(-60.0, 60.0, n.y()));
    }

} // namespace

Phantom make_thorax_phantom(const ThoraxParameters& parameters, const Job& job)
{
    check(parameters);
    return Painter(parameters, job).paint();
}

} // namespace retractor::datasets
