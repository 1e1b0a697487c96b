#include "datasets/segmentation/lungs.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/statistics.h"

#include <algorithm>
#include <cmath>

namespace retractor::datasets::segmentation {

namespace {

    constexpr int kAirHu = -400; // half-way between inflated lung and soft tissue
    constexpr int kAirwayHu = -600;
    constexpr int kLowest = -32768;
    constexpr double kLeastLungMl = 600.0; // both lungs together; more than the gas of a full colon
    constexpr double kPieceMl = 40.0; // smaller pieces of air belong to bowel, oesophagus or wounds

    struct Piece {
        double volume_ml = 0.0;
        double mean_hu = 0.0;
        Vec3 centre = Vec3::Zero(); ///< world mm
    };

    std::vector<Piece> describe(const WorkingImage& image, const Pieces& pieces)
    {
        std::vector<Piece> out(pieces.voxels.size());
        std::size_t v = 0;
        for (int k = 0; k < image.grid.size[2]; ++k)
            for (int j = 0; j < image.grid.size[1]; ++j)
                for (int i = 0; i < image.grid.size[0]; ++i, ++v)
                    if (const auto piece = pieces.piece_of[v]; piece > 0) {
                        Piece& p = out[static_cast<std::size_t>(piece - 1)];
                        p.mean_hu += image.hu[v];
                        p.centre += Vec3(i, j, k);
                    }
        for (std::size_t n = 0; n < out.size(); ++n) {
            const auto count = static_cast<double>(pieces.voxels[n]);
            out[n].volume_ml = count * image.grid.voxel_volume() / 1000.0;
            out[n].mean_hu /= count;
            out[n].centre = image.grid.world(out[n].centre / count);
        }
        return out;
    }

    /// Finds gas in stomach and bowel. The image may not resolve the thin walls between this gas and the lung. The gas
    /// is purer than lung, lies low, and has little border with lung (unlike a bulla).
    Mask gut_gas(const WorkingImage& image, const Mask& air)
    {
        constexpr int kCells = 2;
        constexpr double kLeastMl = 5.0;
        constexpr double kMostLungBorder = 0.4;
        const Extent extent = image.extent();
        const Extent cells = coarse_extent(extent, kCells);
        std::vector<std::int16_t> inside;
        for (std::size_t v = 0; v < air.size(); ++v)
            if (air[v] != 0)
                inside.push_back(image.hu[v]);
        if (inside.empty())
            return Mask(air.size(), 0);
        const int pure_hu = std::min(-920, (upper_median(inside) - 1000) / 2);
        const Mask pure = coarse_mask(extent, common(threshold(image.hu, kLowest, pure_hu), air), kCells, 0.6);
        const Mask air_cells = coarse_mask(extent, air, kCells, 0.5);
        const Pieces pieces = connected_pieces(cells, pure);
        double lung_z = 0.0;
        const auto plane = static_cast<std::size_t>(cells.size[0]) * static_cast<std::size_t>(cells.size[1]);
        for (std::size_t c = 0; c < air_cells.size(); ++c)
            lung_z += air_cells[c] != 0 ? static_cast<double>(c / plane) : 0.0;
        lung_z /= std::max(1.0, static_cast<double>(count_set(air_cells)));
        Mask gas(pure.size(), 0);
        for (std::size_t n = 0; n < pieces.voxels.size(); ++n) {
            Mask piece(pure.size());
            double z = 0.0;
            for (std::size_t c = 0; c < piece.size(); ++c) {
                piece[c] = pieces.piece_of[c] == static_cast<std::int32_t>(n + 1) ? 1 : 0;
                z += piece[c] != 0 ? static_cast<double>(c / plane) : 0.0;
            }
            if (volume_ml(cells, piece) < kLeastMl)
                break;
            if (z / static_cast<double>(pieces.voxels[n]) > lung_z)
                continue;
            const Mask all(piece.size(), 1);
            // The border lies two steps away, because the first step reaches the rim, where gas and wall share cells.
            const Mask near = grown_by_a_voxel(cells, piece, all);
            const Mask border = without(grown_by_a_voxel(cells, near, all), near);
            const auto border_air = static_cast<double>(count_set(common(border, air_cells)));
            if (border_air < kMostLungBorder * static_cast<double>(count_set(border)))
                gas = united(gas, piece);
        }
        Mask fine = common(fine_values(extent, gas, kCells), air);
        for (int step = 0; step < kCells + 1; ++step)
            fine = grown_by_a_voxel(extent, fine, air);
        return fine;
    }

    /// Finds the pieces of air that are lung, with the windpipe: large, textured (gas in the bowel is pure), and
    /// connected over more than one voxel.
    Mask lung_air(const WorkingImage& image, const Mask& air)
    {
        constexpr double kPureGas = -960.0; // mean HU; even emphysema is denser
        constexpr double kBelow = 60.0; // mm below the middle of the largest piece
        const Extent extent = image.extent();
        const Pieces pieces = connected_pieces(extent, shrunk_by_a_voxel(extent, air));
        const std::vector<Piece> described = describe(image, pieces);
        std::vector<char> keep(pieces.voxels.size() + 1, 0);
        const Piece* main = nullptr;
        for (std::size_t n = 0; n < described.size() && described[n].volume_ml > kPieceMl; ++n) {
            const Piece& piece = described[n];
            if (piece.mean_hu < kPureGas)
                continue;
            if (main == nullptr)
                main = &piece;
            keep[n + 1] = piece.centre.z() > main->centre.z() - kBelow ? 1 : 0;
        }
        Mask seeds(air.size());
        for (std::size_t v = 0; v < seeds.size(); ++v)
            seeds[v] = static_cast<std::uint8_t>(keep[static_cast<std::size_t>(pieces.piece_of[v])]);
        const double found = volume_ml(extent, seeds);
        if (found < kLeastLungMl)
            throw InputError("no lungs were found: air inside the body (below " + std::to_string(kAirHu)
                    + " HU) that could be lung comes to " + std::to_string(std::lround(found))
                    + " ml; a chest CT with both lungs in view is needed",
                "lungs");
        return grown_by_a_voxel(extent, grown_by_a_voxel(extent, seeds, air), air);
    }

    /// An area of air in an axial plane.
    struct Area {
        std::vector<std::size_t> voxels;
        double mm2 = 0.0;
        double x = 0.0; ///< middle of the area, index
        double y = 0.0;
    };

    std::vector<Area> areas_in_plane(const Extent& extent, const Mask& air, int k)
    {
        const auto nx = static_cast<std::size_t>(extent.size[0]);
        const std::size_t first = static_cast<std::size_t>(k) * nx * static_cast<std::size_t>(extent.size[1]);
        const std::size_t last = first + nx * static_cast<std::size_t>(extent.size[1]);
        std::vector<char> seen(last - first, 0);
        std::vector<Area> areas;
        for (std::size_t start = first; start < last; ++start) {
            if (air[start] == 0 || seen[start - first] != 0)
                continue;
            Area area;
            area.voxels.push_back(start);
            seen[start - first] = 1;
            const auto reach = [&](std::size_t v) {
                if (air[v] != 0 && seen[v - first] == 0) {
                    seen[v - first] = 1;
                    area.voxels.push_back(v);
                }
            };
            for (std::size_t n = 0; n < area.voxels.size(); ++n) {
                const std::size_t v = area.voxels[n];
                const std::size_t i = (v - first) % nx;
                area.x += static_cast<double>(i);
                area.y += static_cast<double>((v - first) / nx);
                if (i > 0)
                    reach(v - 1);
                if (i + 1 < nx)
                    reach(v + 1);
                if (v >= first + nx)
                    reach(v - nx);
                if (v + nx < last)
                    reach(v + nx);
            }
            const auto count = static_cast<double>(area.voxels.size());
            area.mm2 = count * extent.spacing[0] * extent.spacing[1];
            area.x /= count;
            area.y /= count;
            areas.push_back(std::move(area));
        }
        return areas;
    }

    constexpr double kLeastTrachea = 45.0; // mm^2
    constexpr double kMostTrachea = 750.0;

    bool overlap(const Area& above, const Area& below, std::size_t plane)
    {
        for (const std::size_t v : above.voxels)
            if (std::binary_search(below.voxels.begin(), below.voxels.end(), v - plane))
                return true;
        return false;
    }

    struct Airway {
        std::vector<std::size_t> voxels;
        int planes = 0;
        int carina = -1; ///< plane where the windpipe divides
    };

    /// Follows the windpipe downwards from an area: one area, then two areas, until both open into the lung.
    Airway follow_airway(const Extent& extent, const Mask& air, int top, const Area& start)
    {
        constexpr double kBronchiBelow = 35.0; // mm below the carina, where the bronchi have divided
        constexpr double kLeastBronchus = 30.0; // mm^2
        constexpr double kMostBronchus = 450.0;
        const std::size_t plane = static_cast<std::size_t>(extent.size[0]) * static_cast<std::size_t>(extent.size[1]);
        Airway airway;
        std::vector<Area> current { start };
        double usual = start.mm2;
        for (int k = top;; --k) {
            for (Area& area : current) {
                airway.voxels.insert(airway.voxels.end(), area.voxels.begin(), area.voxels.end());
                std::sort(area.voxels.begin(), area.voxels.end());
            }
            ++airway.planes;
            if (k == 0 || (airway.carina >= 0 && (airway.carina - k) * extent.spacing[2] > kBronchiBelow))
                return airway;
            std::vector<Area> next;
            int below = 0; // counts also areas that have opened into the lung
            for (Area& area : areas_in_plane(extent, air, k - 1)) {
                std::sort(area.voxels.begin(), area.voxels.end());
                const double most = airway.carina < 0 ? std::max(2.2 * usual, 200.0) : kMostBronchus;
                const bool reached = std::any_of(
                    current.begin(), current.end(), [&](const Area& above) { return overlap(above, area, plane); });
                if (!reached || area.mm2 < kLeastBronchus)
                    continue;
                ++below;
                if (area.mm2 < std::min(most, kMostTrachea))
                    next.push_back(std::move(area));
            }
            if (airway.carina < 0 && below >= 2)
                airway.carina = k - 1;
            if (next.empty())
                return airway;
            if (airway.carina < 0)
                usual = 0.8 * usual + 0.2 * next.front().mm2;
            current = std::move(next);
        }
    }

    /// Finds the longest tube of suitable width that descends near the middle of the body.
    Airway find_airway(const Extent& extent, const Mask& air, const Mask& body)
    {
        constexpr double kMidline = 40.0; // largest distance from the midline, mm
        constexpr double kLeastLength = 25.0;
        constexpr double kSearch = 0.5; // share of the image, from the top
        Airway best;
        Mask used(air.size(), 0);
        for (int k = extent.size[2] - 1; k > (1.0 - kSearch) * extent.size[2]; --k) {
            double middle = 0.0;
            double count = 0.0;
            const std::size_t plane
                = static_cast<std::size_t>(extent.size[0]) * static_cast<std::size_t>(extent.size[1]);
            for (std::size_t n = 0; n < plane; ++n)
                if (body[static_cast<std::size_t>(k) * plane + n] != 0) {
                    middle += static_cast<double>(n % static_cast<std::size_t>(extent.size[0]));
                    count += 1.0;
                }
            if (count == 0.0)
                continue;
            middle /= count;
            for (const Area& area : areas_in_plane(extent, air, k)) {
                if (area.mm2 < kLeastTrachea || area.mm2 > kMostTrachea || used[area.voxels.front()] != 0
                    || std::abs(area.x - middle) * extent.spacing[0] > kMidline)
                    continue;
                Airway airway = follow_airway(extent, air, k, area);
                for (const std::size_t v : airway.voxels)
                    used[v] = 1;
                if (airway.planes > best.planes)
                    best = std::move(airway);
            }
            if (best.planes * extent.spacing[2] > 2.0 * kLeastLength)
                break;
        }
        return best.planes * extent.spacing[2] >= kLeastLength ? best : Airway {};
    }

    constexpr std::uint8_t kLeft = 1, kRight = 2;

    /// Mean index along x of one piece.
    double middle_x(const Extent& cells, const Pieces& pieces, std::int32_t piece)
    {
        RETRACTOR_ASSERT(piece > 0 && static_cast<std::size_t>(piece) <= pieces.voxels.size());
        double sum = 0.0;
        for (std::size_t v = 0; v < pieces.piece_of.size(); ++v)
            if (pieces.piece_of[v] == piece)
                sum += static_cast<double>(v % static_cast<std::size_t>(cells.size[0]));
        return sum / static_cast<double>(pieces.voxels[static_cast<std::size_t>(piece - 1)]);
    }

    /// Finds the cores of both lungs, by erosion until two large pieces remain. Returns nothing when the lungs stay
    /// one piece.
    std::vector<std::uint8_t> two_cores(const Extent& cells, const Mask& solid)
    {
        constexpr double kLeastShare = 0.12; // least share of the smaller lung in both lungs
        for (double radius = 0.0; radius < 16.0; radius += 3.0) {
            const Pieces pieces = connected_pieces(cells, radius > 0.0 ? eroded(cells, solid, radius) : solid);
            if (pieces.voxels.size() < 2
                || static_cast<double>(pieces.voxels[1])
                    < kLeastShare * static_cast<double>(pieces.voxels[0] + pieces.voxels[1]))
                continue;
            const std::int32_t left = middle_x(cells, pieces, 1) > middle_x(cells, pieces, 2) ? 1 : 2;
            std::vector<std::uint8_t> side(solid.size(), 0);
            for (std::size_t v = 0; v < side.size(); ++v)
                if (pieces.piece_of[v] == 1 || pieces.piece_of[v] == 2)
                    side[v] = pieces.piece_of[v] == left ? kLeft : kRight;
            return side;
        }
        return {};
    }

    /// Takes the largest piece as one lung, on the side of the image where its middle lies.
    std::vector<std::uint8_t> one_core(const Extent& cells, const Mask& solid, std::vector<std::string>& warnings)
    {
        const Pieces pieces = connected_pieces(cells, solid);
        const bool left = !pieces.voxels.empty() && middle_x(cells, pieces, 1) > 0.5 * cells.size[0];
        std::vector<std::uint8_t> side(solid.size(), 0);
        for (std::size_t v = 0; v < side.size(); ++v)
            side[v] = pieces.piece_of[v] == 1 ? (left ? kLeft : kRight) : 0;
        warnings.push_back(
            std::string("only one lung was found (") + (left ? "left" : "right") + "), or both could not be parted");
        return side;
    }

    /// Gives each cell of `all` the side of the core that is nearest through `all`. The breadth-first search begins at
    /// both cores at once.
    void grow_sides(const Extent& cells, const Mask& all, std::vector<std::uint8_t>& side)
    {
        RETRACTOR_ASSERT(all.size() == cells.voxel_count() && side.size() == all.size());
        const auto nx = static_cast<std::size_t>(cells.size[0]);
        const std::size_t nxy = nx * static_cast<std::size_t>(cells.size[1]);
        std::vector<std::size_t> front;
        for (std::size_t v = 0; v < side.size(); ++v)
            if (side[v] != 0)
                front.push_back(v);
        for (std::size_t n = 0; n < front.size(); ++n) {
            const std::size_t v = front[n];
            const auto reach = [&](bool inside, std::size_t next) {
                if (inside && all[next] != 0 && side[next] == 0) {
                    side[next] = side[v];
                    front.push_back(next);
                }
            };
            reach(v % nx > 0, v - 1);
            reach(v % nx + 1 < nx, v + 1);
            reach(v % nxy >= nx, v - nx);
            reach(v % nxy + nx < nxy, v + nx);
            reach(v >= nxy, v - nxy);
            reach(v + nxy < side.size(), v + nxy);
        }
    }

    /// Divides the lungs: 1 left, 2 right, 0 elsewhere. Lungs that touch are divided where the air between them is
    /// thinnest, because each cell joins the core that is nearest through air.
    std::vector<std::uint8_t> sides(const Extent& extent, const Mask& lungs, std::vector<std::string>& warnings)
    {
        constexpr int kCells = 2;
        const Extent cells = coarse_extent(extent, kCells);
        const Mask solid = coarse_mask(extent, lungs, kCells, 0.6);
        std::vector<std::uint8_t> side = two_cores(cells, solid);
        if (side.empty())
            side = one_core(cells, solid, warnings);
        grow_sides(cells, coarse_mask(extent, lungs, kCells, 0.0), side);
        return fine_values(extent, side, kCells);
    }

    void check_volumes(const Extent& extent, const Lungs& lungs, std::vector<std::string>& warnings)
    {
        constexpr double kLeast = 700.0;
        const double left = volume_ml(extent, lungs.left);
        const double right = volume_ml(extent, lungs.right);
        for (const auto& [name, ml] : { std::pair { "left", left }, std::pair { "right", right } })
            if (ml > 0.0 && ml < kLeast)
                warnings.push_back("the " + std::string(name) + " lung has only " + std::to_string(std::lround(ml))
                    + " ml of air: collapsed, consolidated, with fluid, or cut off by the image");
        if (left > 0.0 && right > 0.0 && std::max(left, right) > 2.0 * std::min(left, right))
            warnings.emplace_back("one lung holds more than twice the air of the other: look for fluid or collapse");
    }

} // namespace

Lungs segment_lungs(const WorkingImage& image, const Mask& body)
{
    const Extent extent = image.extent();
    RETRACTOR_ASSERT(body.size() == extent.voxel_count());
    Lungs lungs;
    const Mask air = common(threshold(image.hu, kLowest, kAirHu), body);
    const Mask lung = lung_air(image, without(air, gut_gas(image, air)));
    // This threshold lies well below the threshold of the lung, so that coarse images still show the thin walls between
    // windpipe and lung.
    const Airway airway = find_airway(extent, common(threshold(image.hu, kLowest, kAirwayHu), body), body);
    Mask tube(air.size(), 0);
    for (const std::size_t v : airway.voxels)
        tube[v] = 1;
    lungs.trachea = grown_by_a_voxel(extent, tube, air);
    if (airway.planes == 0)
        lungs.warnings.emplace_back("the windpipe was not found: it is part of the lungs or of the mediastinum");
    else if (airway.carina >= 0)
        lungs.carina_z = image.grid.world(Vec3(0.0, 0.0, airway.carina)).z();
    const std::vector<std::uint8_t> side = sides(extent, without(lung, lungs.trachea), lungs.warnings);
    constexpr double kVessel = 250.0; // mm^2, the largest section of a vessel inside the lung
    for (const int number : { 1, 2 }) {
        Mask one(air.size());
        for (std::size_t v = 0; v < one.size(); ++v)
            one[v] = lung[v] != 0 && side[v] == number && lungs.trachea[v] == 0 ? 1 : 0;
        Mask filled = without(small_holes_filled(extent, one, kVessel), lungs.trachea);
        (number == 1 ? lungs.left : lungs.right) = std::move(filled);
    }
    lungs.right = without(lungs.right, lungs.left); // both sides may have filled the same hole
    check_volumes(extent, lungs, lungs.warnings);
    return lungs;
}

} // namespace retractor::datasets::segmentation
