#include "planner/anatomy/anatomy.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "planner/anatomy/rib_name.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace retractor::planner {

namespace {

    constexpr double kRibNodeDeg = 4.0; ///< spacing of a rib's centre-line points round the chest
    constexpr double kSternumNodeMm = 6.0;
    /// A bone has an axis when its largest variance is at least this many times the second largest.
    constexpr double kElongated = 2.0;

    /// The voxels of one structure, by index. Sums of whole numbers are exact in any order, so turned and mirrored
    /// grids give the same landmarks.
    struct Voxels {
        std::vector<std::array<int, 3>> indices;

        bool empty() const { return indices.empty(); }
        Vec3 mean_index() const
        {
            RETRACTOR_ASSERT(!empty());
            Vec3 sum = Vec3::Zero();
            for (const auto& v : indices)
                sum += Vec3(v[0], v[1], v[2]);
            return sum / static_cast<double>(indices.size());
        }
    };

    Vec3 centroid(const mesh::ImageGrid& grid, const Voxels& voxels) { return grid.world(voxels.mean_index()); }

    /// Variances (ascending) and axes of a structure, world frame.
    Eigen::SelfAdjointEigenSolver<Mat3> principal_axes(const mesh::ImageGrid& grid, const Voxels& voxels)
    {
        const Vec3 mean = voxels.mean_index();
        Mat3 covariance = Mat3::Zero();
        for (const auto& v : voxels.indices) {
            const Vec3 x = grid.spacing.cwiseProduct(Vec3(v[0], v[1], v[2]) - mean);
            covariance += x * x.transpose();
        }
        covariance /= static_cast<double>(voxels.indices.size());
        return Eigen::SelfAdjointEigenSolver<Mat3>(grid.direction * covariance * grid.direction.transpose());
    }

    struct RibVoxels {
        const mesh::LabelInfo* info = nullptr;
        bool left = true;
        int number = 0;
        Voxels voxels;
    };

    struct Collected {
        Voxels spine, sternum;
        std::vector<RibVoxels> ribs;
    };

    /// Reads side and number of a rib's label: "rib_left_5".
    bool parse_rib(const mesh::LabelInfo& info, RibVoxels& rib)
    {
        const std::optional<RibName> name = rib_name(info.name);
        if (!name)
            return false;
        rib.number = name->number;
        rib.left = name->left;
        rib.info = &info;
        return true;
    }

    Collected collect(const mesh::LabelVolume& labels)
    {
        mesh::check_grid(labels.grid);
        if (labels.voxels.size() != labels.grid.voxel_count())
            throw InputError("the label volume's voxel count does not match its size");
        Collected found;
        std::size_t largest = 0;
        for (const mesh::LabelInfo& info : labels.table)
            largest = std::max(largest, static_cast<std::size_t>(info.id));
        found.ribs.reserve(labels.table.size()); // pointers into it are kept below
        std::vector<Voxels*> destination(largest + 1, nullptr);
        for (const mesh::LabelInfo& info : labels.table) {
            if (info.id == 0)
                continue;
            RibVoxels rib;
            if (info.name == "spine" || info.name.starts_with("vertebrae"))
                destination[info.id] = &found.spine;
            else if (info.name == "sternum")
                destination[info.id] = &found.sternum;
            else if (parse_rib(info, rib)) {
                found.ribs.push_back(rib);
                destination[info.id] = &found.ribs.back().voxels;
            }
        }
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
            if (label <= largest && destination[label] != nullptr)
                destination[label]->indices.push_back({ i, j, k });
        });
        std::erase_if(found.ribs, [](const RibVoxels& rib) { return rib.voxels.empty(); });
        std::sort(found.ribs.begin(), found.ribs.end(), [](const RibVoxels& a, const RibVoxels& b) {
            return std::pair(!a.left, a.number) < std::pair(!b.left, b.number);
        });
        return found;
    }

    void require(const Collected& found)
    {
        if (found.spine.empty())
            throw InputError(
                "no voxel is labelled \"spine\" or \"vertebrae_*\": label the spine, it gives the patient's long axis",
                "spine");
        if (found.sternum.empty())
            throw InputError(
                "no voxel is labelled \"sternum\": label the sternum, it tells front from back", "sternum");
        for (const bool left : { true, false }) {
            const auto count = std::count_if(
                found.ribs.begin(), found.ribs.end(), [&](const RibVoxels& r) { return r.left == left; });
            const std::string name = left ? "rib_left_*" : "rib_right_*";
            if (count < 2)
                throw InputError("fewer than two labels \"" + name
                        + "\" have voxels: label the ribs by side and number, they tell up from down and left from "
                          "right",
                    name);
        }
    }

    /// The unit `axis`, with the sign that points towards the first rib.
    Vec3 towards_first_rib(const mesh::ImageGrid& grid, const std::vector<RibVoxels>& ribs, const Vec3& axis)
    {
        double mean_number = 0.0, mean_height = 0.0;
        std::vector<double> heights;
        for (const RibVoxels& rib : ribs) {
            heights.push_back(axis.dot(centroid(grid, rib.voxels) - grid.origin));
            mean_number += rib.number;
            mean_height += heights.back();
        }
        const auto n = static_cast<double>(ribs.size());
        mean_number /= n;
        mean_height /= n;
        double both = 0.0, numbers = 0.0, squares = 0.0;
        for (std::size_t r = 0; r < ribs.size(); ++r) {
            const double dn = ribs[r].number - mean_number, dh = heights[r] - mean_height;
            both += dn * dh;
            numbers += dn * dn;
            squares += dh * dh;
        }
        constexpr double kOrdered = 0.7; // correlation of number and height in a rightly numbered chest is above 0.95
        if (!(numbers > 0.0) || !(std::abs(both) > kOrdered * std::sqrt(numbers * squares)))
            throw InputError("the rib numbers do not follow the spine: check the numbering of the rib labels", "rib_*");
        return both < 0.0 ? axis : Vec3(-axis);
    }

    AnatomicalFrame find_frame(const mesh::ImageGrid& grid, const Collected& found)
    {
        AnatomicalFrame frame;
        const auto spine = principal_axes(grid, found.spine);
        if (!(spine.eigenvalues()[2] > kElongated * spine.eigenvalues()[1]))
            throw InputError(
                "the labelled spine is too short to give the patient's long axis: label more vertebrae", "spine");
        frame.superior = towards_first_rib(grid, found.ribs, spine.eigenvectors().col(2));

        const Vec3 back = centroid(grid, found.spine), front = centroid(grid, found.sternum);
        frame.origin = 0.5 * (back + front);
        const Vec3 forward = front - back;
        const Vec3 square = forward - frame.superior.dot(forward) * frame.superior;
        if (!(square.norm() > 0.3 * forward.norm()))
            throw InputError("the sternum does not lie in front of the spine: check both labels", "sternum");
        frame.anterior = square.normalized();
        frame.left = frame.superior.cross(frame.anterior);

        for (const RibVoxels& rib : found.ribs) {
            const double side = frame.left.dot(centroid(grid, rib.voxels) - back);
            if ((side > 0.0) != rib.left)
                throw InputError("\"" + rib.info->name + "\" lies on the " + (rib.left ? "right" : "left")
                        + " of the patient: left and right are swapped, or the volume is mirrored",
                    rib.info->name);
        }
        return frame;
    }

    /// Centroids of bins that overlap linearly. They are a continuous function of the voxels, without ties at the bins'
    /// borders.
    class HatBins {
    public:
        HatBins(double low, double high, double spacing)
            : low_(low)
        {
            // The small shift keeps round-off from changing the count of a range that is a whole number of bins.
            const int count = std::max(1, static_cast<int>(std::ceil((high - low) / spacing - 0.0123)));
            width_ = (high - low) / count;
            bins_.resize(static_cast<std::size_t>(count) + 1);
        }
        void add(double parameter, const Vec3& point)
        {
            const double x = width_ > 0.0 ? (parameter - low_) / width_ : 0.0;
            const auto last = static_cast<double>(bins_.size() - 1);
            const double floor = std::clamp(std::floor(x), 0.0, last - 1.0);
            const auto b = static_cast<std::size_t>(floor);
            RETRACTOR_ASSERT(b + 1 < bins_.size());
            put(bins_[b], 1.0 - (x - floor), parameter, point);
            put(bins_[b + 1], x - floor, parameter, point);
        }
        struct Bin {
            double weight = 0.0, parameter = 0.0;
            Vec3 sum = Vec3::Zero();
        };
        const std::vector<Bin>& bins() const { return bins_; }

    private:
        static void put(Bin& bin, double weight, double parameter, const Vec3& point)
        {
            bin.weight += weight;
            bin.parameter += weight * parameter;
            bin.sum += weight * point;
        }
        double low_, width_ = 0.0;
        std::vector<Bin> bins_;
    };

    RibLine rib_line(const mesh::ImageGrid& grid, const AnatomicalFrame& frame, const RibVoxels& rib)
    {
        RibLine line { .label = rib.info->id,
            .name = rib.info->name,
            .left = rib.left,
            .number = rib.number,
            .points = {},
            .angle_deg = {} };
        std::vector<std::pair<double, Vec3>> places;
        places.reserve(rib.voxels.indices.size());
        double low = 360.0, high = -360.0;
        for (const auto& v : rib.voxels.indices) {
            // Positions relative to the chest axis keep the sums small.
            const Vec3 place = grid.world(Vec3(v[0], v[1], v[2]));
            const double angle = angle_round_chest(frame, rib.left, place);
            low = std::min(low, angle);
            high = std::max(high, angle);
            places.emplace_back(angle, place - frame.origin);
        }
        HatBins bins(low, high, kRibNodeDeg);
        for (const auto& [angle, p] : places)
            bins.add(angle, p);
        for (const HatBins::Bin& bin : bins.bins())
            // Less weight than a voxel is a gap in the rib.
            if (bin.weight > 0.3) {
                line.points.push_back(frame.origin + bin.sum / bin.weight);
                line.angle_deg.push_back(bin.parameter / bin.weight);
            }
        return line;
    }

    /// The voxels of some labels near a point: their weighted mean, and their share of all weights.
    std::pair<Vec3, double> local_mean(
        const mesh::LabelVolume& labels, const mesh::LabelFlags& counts, const Vec3& point, double radius)
    {
        const mesh::ImageGrid& grid = labels.grid;
        const Vec3 centre = grid.index(point);
        const Vec3 reach = Vec3::Constant(radius).cwiseQuotient(grid.spacing);
        Vec3 sum = Vec3::Zero();
        double found = 0.0, all = 0.0;
        const auto low = [&](int a) { return static_cast<int>(std::ceil(centre[a] - reach[a])); };
        const auto high = [&](int a) { return static_cast<int>(std::floor(centre[a] + reach[a])); };
        for (int k = low(2); k <= high(2); ++k)
            for (int j = low(1); j <= high(1); ++j)
                for (int i = low(0); i <= high(0); ++i) {
                    const Vec3 offset = grid.spacing.cwiseProduct(Vec3(i, j, k) - centre);
                    const double weight = std::max(0.0, 1.0 - offset.squaredNorm() / (radius * radius));
                    all += weight * weight;
                    if (!grid.contains(i, j, k) || counts[labels.voxels[grid.offset(i, j, k)]] == 0)
                        continue;
                    sum += weight * weight * offset;
                    found += weight * weight;
                }
        return { found > 0.0 ? Vec3(point + grid.direction * (sum / found)) : point, found / all };
    }

    /// Follows the cartilage from the rib's front end. Each round makes a step forwards, and then moves to the middle
    /// of the cartilage there.
    void follow_cartilage(const mesh::LabelVolume& labels, const AnatomicalFrame& frame, RibLine& line)
    {
        constexpr double kStepMm = 4.0, kRadiusMm = 9.0, kLeastShare = 0.08, kTurn = 0.4;
        constexpr int kMostSteps = 80;
        const mesh::LabelFlags counts = mesh::flagged_labels(
            labels.table, [](const mesh::LabelInfo& info) { return info.name.find("cartilage") != std::string::npos; });
        if (std::find(counts.begin(), counts.end(), 1) == counts.end() || line.points.size() < 4)
            return;
        Vec3 here = line.points.back();
        Vec3 ahead = (here - line.points[line.points.size() - 4]).normalized();
        for (int n = 0; n < kMostSteps; ++n) {
            const auto [middle, share] = local_mean(labels, counts, here + kStepMm * ahead, kRadiusMm);
            const Vec3 step = middle - here;
            if (share < kLeastShare || !(step.dot(ahead) > 0.25 * kStepMm))
                return;
            const double angle = angle_round_chest(frame, line.left, middle);
            if (angle > line.angle_deg.back()) {
                line.points.push_back(middle);
                line.angle_deg.push_back(angle);
            }
            here = middle;
            ahead = ((1.0 - kTurn) * ahead + kTurn * step.normalized()).normalized();
        }
    }

    SternumAxis sternum_axis(const mesh::ImageGrid& grid, const AnatomicalFrame& frame, const Voxels& voxels)
    {
        const auto axes = principal_axes(grid, voxels);
        if (!(axes.eigenvalues()[2] > kElongated * axes.eigenvalues()[1]))
            throw InputError(
                "the labelled sternum is too short to give its axis: label it from the notch to the xiphoid",
                "sternum");
        SternumAxis sternum;
        const Vec3 long_axis = axes.eigenvectors().col(2);
        if (!(std::abs(long_axis.dot(frame.superior)) > 0.5))
            throw InputError("the labelled sternum does not run along the spine: check the label", "sternum");
        sternum.axis = long_axis.dot(frame.superior) > 0.0 ? long_axis : Vec3(-long_axis);

        const Vec3 centre = centroid(grid, voxels);
        double low = 1e300, high = -1e300;
        for (const auto& v : voxels.indices) {
            const double s = sternum.axis.dot(grid.world(Vec3(v[0], v[1], v[2])) - centre);
            low = std::min(low, s);
            high = std::max(high, s);
        }
        // The midline is fitted by a parabola: the breastbone bulges forwards, and the middle of a bin moves with the
        // bone's notches.
        Mat3 moments = Mat3::Zero();
        Mat3 values = Mat3::Zero();
        const double scale = 1.0 / std::max(high - low, 1e-9);
        for (const auto& v : voxels.indices) {
            const Vec3 p = grid.world(Vec3(v[0], v[1], v[2])) - centre;
            const double s = sternum.axis.dot(p) * scale;
            const Vec3 row(1.0, s, s * s);
            moments += row * row.transpose();
            values += row * (p - sternum.axis.dot(p) * sternum.axis).transpose();
        }
        const Mat3 fit = moments.fullPivLu().solve(values);
        const double half_voxel = 0.5 * (grid.direction.transpose() * sternum.axis).cwiseAbs().dot(grid.spacing);
        low -= half_voxel;
        high += half_voxel;
        const int count = std::max(2, static_cast<int>(std::ceil((high - low) / kSternumNodeMm - 0.0123)));
        for (int n = 0; n <= count; ++n) {
            const double s = high + (low - high) * n / count;
            const Vec3 row(1.0, s * scale, s * s * scale * scale);
            sternum.midline.push_back(centre + s * sternum.axis + fit.transpose() * row);
        }
        sternum.top = sternum.midline.front();
        sternum.bottom = sternum.midline.back();
        return sternum;
    }

} // namespace

Anatomy find_anatomy(const mesh::LabelVolume& labels)
{
    const Collected found = collect(labels);
    require(found);
    Anatomy anatomy;
    anatomy.frame = find_frame(labels.grid, found);
    anatomy.sternum = sternum_axis(labels.grid, anatomy.frame, found.sternum);
    for (const RibVoxels& rib : found.ribs) {
        anatomy.ribs.push_back(rib_line(labels.grid, anatomy.frame, rib));
        follow_cartilage(labels, anatomy.frame, anatomy.ribs.back());
    }
    return anatomy;
}

const RibLine& find_rib(const Anatomy& anatomy, bool left, int number)
{
    for (const RibLine& rib : anatomy.ribs)
        if (rib.left == left && rib.number == number)
            return rib;
    const std::string name = (left ? "rib_left_" : "rib_right_") + std::to_string(number);
    throw InputError("no voxel is labelled \"" + name + "\": label this rib or choose another space", name);
}

double angle_round_chest(const AnatomicalFrame& frame, bool left, const Vec3& place)
{
    const Vec3 from_origin = place - frame.origin;
    const double lateral = (left ? 1.0 : -1.0) * frame.left.dot(from_origin);
    const double angle = std::atan2(lateral, -frame.anterior.dot(from_origin)) * 180.0 / std::numbers::pi;
    return angle < -90.0 ? angle + 360.0 : angle;
}

Vec3 point_at_angle(const RibLine& rib, double angle_deg)
{
    RETRACTOR_ASSERT(!rib.points.empty() && rib.points.size() == rib.angle_deg.size());
    const auto above = std::upper_bound(rib.angle_deg.begin(), rib.angle_deg.end(), angle_deg);
    if (above == rib.angle_deg.begin())
        return rib.points.front();
    if (above == rib.angle_deg.end())
        return rib.points.back();
    const auto n = static_cast<std::size_t>(above - rib.angle_deg.begin());
    const double t = (angle_deg - rib.angle_deg[n - 1]) / (rib.angle_deg[n] - rib.angle_deg[n - 1]);
    return (1.0 - t) * rib.points[n - 1] + t * rib.points[n];
}

Vec3 label_centroid(const mesh::LabelVolume& labels, std::string_view name)
{
    const mesh::LabelInfo* info = mesh::find_label(labels.table, name);
    if (info == nullptr)
        throw InputError("there is no label \"" + std::string(name) + "\" in the label table", std::string(name));
    Voxels voxels;
    mesh::visit_voxels(labels, [&](int i, int j, int k, Label label) {
        if (label == info->id)
            voxels.indices.push_back({ i, j, k });
    });
    if (voxels.empty())
        throw InputError("no voxel is labelled \"" + std::string(name) + "\"", std::string(name));
    return centroid(labels.grid, voxels);
}

} // namespace retractor::planner
