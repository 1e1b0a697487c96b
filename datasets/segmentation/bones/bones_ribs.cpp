// Follows the ribs round the chest. The bone near the pleura is divided into sectors of a few degrees about the axis of
// the chest. In a sector each rib is one piece. Touching pieces of neighbouring sectors belong to one rib when each is
// the best neighbour of the other. A gap is bridged when a piece lies straight ahead.

#include "datasets/segmentation/bones/bones_steps.h"

#include "mesh/base/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace retractor::datasets::segmentation {

namespace {

    constexpr double kSectorDeg = 4.0;
    constexpr int kSectors = 45; // sectors per side
    constexpr double kInnermost = -25.0;
    constexpr double kBesideVertebra = 3.0; ///< mm from the side of the vertebral body, where the heads of ribs lie

    struct Piece {
        int sector = 0;
        bool left = true;
        std::vector<Voxel> voxels;
        Vec3 centre = Vec3::Zero();
        int next = -1, before = -1; ///< neighbouring pieces of the same rib
    };

    /// For each voxel that may be rib: twice its sector, plus 1 on the right side. -1 for other voxels.
    std::vector<std::int8_t> sectors(const WorkingImage& image, const Mask& bone, const Cage& cage)
    {
        std::vector<std::int8_t> sector(bone.size(), -1);
        Voxel v = 0;
        for (int k = 0; k < image.grid.size[2]; ++k) {
            const double z = image.grid.origin.z() + image.grid.spacing.z() * k;
            const Eigen::Vector2d spine = cage.spine(z), centre = cage.centre(z);
            const double half_width = cage.half_width(z);
            const double outermost = cage.rib_limit(z);
            for (int j = 0; j < image.grid.size[1]; ++j)
                for (int i = 0; i < image.grid.size[0]; ++i, ++v) {
                    if (!bone[v])
                        continue;
                    const Vec3 p = image.grid.world(Vec3(i, j, k));
                    const double out = cage.outside_at(p);
                    if (out > outermost || out < kInnermost || in_spine_core(cage, p) || in_sternum_core(cage, p))
                        continue;
                    const double beside = std::abs(p.x() - spine.x());
                    if (beside < half_width + kBesideVertebra && p.y() > spine.y() - 30.0)
                        continue;
                    const int s = std::clamp(static_cast<int>(cage.angle(p) / kSectorDeg), 0, kSectors - 1);
                    sector[v] = static_cast<std::int8_t>(2 * s + (p.x() > centre.x() ? 0 : 1));
                }
        }
        return sector;
    }

    struct Pieces3 {
        std::vector<Piece> pieces;
        /// Number of faces shared by pieces of neighbouring sectors, lower sector first.
        std::map<std::pair<int, int>, int> contact;
    };

    Pieces3 cut(const WorkingImage& image, const std::vector<std::int8_t>& sector)
    {
        constexpr std::size_t kFewest = 4;
        const mesh::ImageGrid& grid = image.grid;
        const auto nx = static_cast<Voxel>(grid.size[0]), ny = static_cast<Voxel>(grid.size[1]);
        const Voxel slice = nx * ny;
        Pieces3 result;
        std::vector<std::int32_t> piece_of(sector.size(), -1);
        std::vector<Voxel> queue;
        // These loops omit the outermost layer of the image, so bone never reaches the border planes.
        const auto inner = [&](Voxel v) {
            const Voxel i = v % nx, j = (v / nx) % ny, k = v / slice;
            return i > 0 && i + 1 < nx && j > 0 && j + 1 < ny && k > 0 && k + 1 < static_cast<Voxel>(grid.size[2]);
        };
        for (Voxel seed = 0; seed < sector.size(); ++seed) {
            if (sector[seed] < 0 || piece_of[seed] >= 0)
                continue;
            const auto id = static_cast<std::int32_t>(result.pieces.size());
            queue.assign(1, seed);
            piece_of[seed] = id;
            Vec3 sum = Vec3::Zero();
            for (std::size_t n = 0; n < queue.size(); ++n) {
                const Voxel v = queue[n];
                sum += Vec3(
                    static_cast<double>(v % nx), static_cast<double>((v / nx) % ny), static_cast<double>(v / slice));
                if (!inner(v))
                    continue;
                for (const Voxel u : { v - 1, v + 1, v - nx, v + nx, v - slice, v + slice })
                    if (sector[u] == sector[seed] && piece_of[u] < 0) {
                        piece_of[u] = id;
                        queue.push_back(u);
                    }
            }
            Piece piece;
            piece.sector = sector[seed] / 2;
            piece.left = sector[seed] % 2 == 0;
            piece.centre = grid.world(sum / static_cast<double>(queue.size()));
            piece.voxels = queue;
            result.pieces.push_back(std::move(piece));
        }
        for (const Piece& piece : result.pieces)
            for (const Voxel v : piece.voxels) {
                if (!inner(v))
                    continue;
                for (const Voxel u : { v - 1, v + 1, v - nx, v + nx, v - slice, v + slice })
                    if (piece_of[u] >= 0 && sector[u] == sector[v] + 2)
                        ++result.contact[{ piece_of[v], piece_of[u] }];
            }
        for (Piece& piece : result.pieces)
            if (piece.voxels.size() < kFewest)
                piece.sector = -10; // noise
        return result;
    }

    /// Removes the outermost voxels of pieces that are much taller than a rib. Such a piece holds a rib and the scapula
    /// behind the rib, or two ribs with the scapula between. Returns the number of such pieces.
    int peel_tall_pieces(const WorkingImage& image, const Cage& cage, const Pieces3& cut_pieces, double by,
        std::vector<std::int8_t>& sector)
    {
        // Limits in mm and degrees. In front, sectors cut ribs at a slant, so pieces are taller.
        constexpr double kTall = 30.0, kFrontDeg = 100.0;
        const mesh::ImageGrid& grid = image.grid;
        const auto nx = static_cast<Voxel>(grid.size[0]), ny = static_cast<Voxel>(grid.size[1]);
        const Voxel slice = nx * ny;
        int peeled = 0;
        for (const Piece& piece : cut_pieces.pieces) {
            const auto [low, high] = std::minmax_element(piece.voxels.begin(), piece.voxels.end());
            if (piece.voxels.empty() || piece.sector < 0 || piece.sector * kSectorDeg > kFrontDeg
                || static_cast<double>(*high / slice - *low / slice) * grid.spacing.z() < kTall)
                continue;
            ++peeled;
            for (const Voxel v : piece.voxels) {
                const Vec3 p = grid.world(Vec3(
                    static_cast<double>(v % nx), static_cast<double>((v / nx) % ny), static_cast<double>(v / slice)));
                if (cage.outside_at(p) > cage.rib_limit(p.z()) - by)
                    sector[v] = -1;
            }
        }
        return peeled;
    }

    void link_touching(Pieces3& cut_pieces)
    {
        auto& pieces = cut_pieces.pieces;
        std::vector<std::pair<int, int>> best_next(pieces.size(), { 0, -1 }), best_before(pieces.size(), { 0, -1 });
        constexpr double kRise = 3.0; // mm; ribs descend forwards, a clavicle across the first rib rises
        constexpr int kRiseCosts = 4;
        for (const auto& [pair, shared] : cut_pieces.contact) {
            const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
            if (pieces[a].sector < 0 || pieces[b].sector < 0)
                continue;
            const bool rises = pieces[b].centre.z() > pieces[a].centre.z() + kRise;
            const int faces = rises ? std::max(1, shared / kRiseCosts) : shared;
            best_next[a] = std::max(best_next[a], { faces, pair.second });
            best_before[b] = std::max(best_before[b], { faces, pair.first });
        }
        for (std::size_t a = 0; a < pieces.size(); ++a) {
            const int b = best_next[a].second;
            if (b >= 0 && best_before[static_cast<std::size_t>(b)].second == static_cast<int>(a)) {
                pieces[a].next = b;
                pieces[static_cast<std::size_t>(b)].before = static_cast<int>(a);
            }
        }
    }

    /// Pieces in order along a rib.
    struct Chain {
        bool left = true;
        std::vector<int> pieces;
    };

    std::vector<Chain> chains(const std::vector<Piece>& pieces)
    {
        std::vector<Chain> all;
        for (std::size_t n = 0; n < pieces.size(); ++n) {
            if (pieces[n].sector < 0 || pieces[n].before >= 0)
                continue;
            Chain chain;
            chain.left = pieces[n].left;
            for (int at = static_cast<int>(n); at >= 0; at = pieces[static_cast<std::size_t>(at)].next)
                chain.pieces.push_back(at);
            all.push_back(std::move(chain));
        }
        return all;
    }

    /// The end of a chain and its direction there (unit), from the last pieces.
    std::pair<Vec3, Vec3> heading(const std::vector<Piece>& pieces, const Chain& chain, bool forwards)
    {
        constexpr std::size_t kBack = 4;
        const auto centre = [&](std::size_t n) {
            return pieces[static_cast<std::size_t>(chain.pieces[forwards ? chain.pieces.size() - 1 - n : n])].centre;
        };
        const std::size_t back = std::min(kBack, chain.pieces.size() - 1);
        const Vec3 end = centre(0);
        return { end, back == 0 ? Vec3(Vec3::Zero()) : Vec3((end - centre(back)).normalized()) };
    }

    /// The misfit of chain b as a continuation of chain a: mm off the straight line, plus a share of the gap. Nothing
    /// when b does not continue a.
    std::optional<double> misfit(const std::vector<Piece>& pieces, const Chain& a, const Chain& b)
    {
        constexpr double kMostGap = 45.0, kMostOff = 12.0, kSlope = 0.35;
        constexpr int kMostSectors = 8;
        const Piece& last = pieces[static_cast<std::size_t>(a.pieces.back())];
        const Piece& first = pieces[static_cast<std::size_t>(b.pieces.front())];
        if (a.left != b.left || first.sector <= last.sector || first.sector > last.sector + kMostSectors)
            return std::nullopt;
        const auto [end, ahead] = heading(pieces, a, true);
        const auto [start, back] = heading(pieces, b, false);
        const Vec3 gap = start - end;
        if (gap.norm() > kMostGap)
            return std::nullopt;
        const Vec3 off_a = gap - gap.dot(ahead) * ahead, off_b = gap - gap.dot(back) * back;
        double off = 0.0;
        const bool long_a = a.pieces.size() > 2, long_b = b.pieces.size() > 2;
        if (long_a && long_b)
            off = 0.5 * (off_a.norm() + off_b.norm());
        else
            off = long_a ? off_a.norm() : long_b ? off_b.norm() : std::abs(gap.z());
        // Ribs bend, so the allowed distance grows with the gap.
        if (off > 4.0 + kSlope * gap.norm() || off > kMostOff)
            return std::nullopt;
        return off + 0.15 * gap.norm();
    }

    /// Joins chains across gaps, in order of rising misfit.
    void bridge(const std::vector<Piece>& pieces, std::vector<Chain>& all)
    {
        for (;;) {
            std::optional<double> best;
            std::size_t first = 0, second = 0;
            for (std::size_t a = 0; a < all.size(); ++a)
                for (std::size_t b = 0; b < all.size(); ++b) {
                    if (a == b)
                        continue;
                    const auto fit = misfit(pieces, all[a], all[b]);
                    if (fit && (!best || *fit < *best)) {
                        best = fit;
                        first = a;
                        second = b;
                    }
                }
            if (!best)
                return;
            Chain &a = all[first], &b = all[second];
            a.pieces.insert(a.pieces.end(), b.pieces.begin(), b.pieces.end());
            all.erase(all.begin() + static_cast<std::ptrdiff_t>(second));
        }
    }

    double length(const RibTrack& rib)
    {
        double sum = 0.0;
        for (std::size_t n = 1; n < rib.line.size(); ++n)
            sum += (rib.line[n] - rib.line[n - 1]).norm();
        return sum;
    }

    /// Moves points that lie off the line, because another structure touches the rib there.
    void straighten(std::vector<Vec3>& line)
    {
        constexpr double kOff = 4.0; // mm from the middle of both neighbours
        for (std::size_t n = 1; n + 1 < line.size(); ++n) {
            const Vec3 between = 0.5 * (line[n - 1] + line[n + 1]);
            if ((line[n] - between).norm() > kOff)
                line[n] = between;
        }
    }

    /// True when a track descends from the spine forwards and is less steep than the side of a vertebra.
    bool runs_like_a_rib(const RibTrack& rib)
    {
        constexpr double kRise = 6.0, kSteep = 2.0; // mm; rise over run
        double run = 0.0;
        for (std::size_t n = 1; n < rib.line.size(); ++n)
            run += (rib.line[n] - rib.line[n - 1]).head<2>().norm();
        const double fall = rib.line.front().z() - rib.line.back().z();
        return fall > -kRise && fall < kSteep * run;
    }

    /// The number of bony pieces in a chain. In front, calcified cartilage continues the rib, but is thinner and turns
    /// up, while ribs only descend.
    std::size_t bony_pieces(const std::vector<Piece>& pieces, const Chain& chain)
    {
        constexpr double kThin = 0.45, kRise = 3.0; // share of the median piece; mm above the lowest piece so far
        constexpr double kFrontDeg = 95.0;
        std::vector<std::size_t> sizes;
        for (const int n : chain.pieces)
            sizes.push_back(pieces[static_cast<std::size_t>(n)].voxels.size());
        const auto median = static_cast<double>(upper_median(sizes));
        constexpr std::size_t kForgiven = 3; // pieces in a row where another structure touches the rib
        double lowest = std::numeric_limits<double>::infinity();
        std::size_t good = 0;
        for (std::size_t n = 0; n < chain.pieces.size(); ++n) {
            const Piece& piece = pieces[static_cast<std::size_t>(chain.pieces[n])];
            const bool front = piece.sector * kSectorDeg > kFrontDeg;
            const bool rises = piece.centre.z() > lowest + kRise;
            lowest = std::min(lowest, piece.centre.z());
            if (!front || (!rises && static_cast<double>(piece.voxels.size()) >= kThin * median))
                good = n + 1;
            else if (n >= good + kForgiven)
                break;
        }
        return good;
    }

} // namespace

std::vector<RibTrack> track_ribs(const WorkingImage& image, const Mask& bone, const Cage& cage)
{
    constexpr double kShortest = 35.0; // mm; the twelfth rib may have 40
    constexpr double kShortestLeaving = 18.0, kBorder = 10.0;
    constexpr double kPieceLength = 9.0; // mm between the centres of neighbouring pieces
    std::vector<std::int8_t> sector = sectors(image, bone, cage);
    Pieces3 cut_pieces = cut(image, sector);
    for (const double by : { 2.0, 4.0, 6.0 }) {
        if (peel_tall_pieces(image, cage, cut_pieces, by, sector) == 0)
            break;
        cut_pieces = cut(image, sector);
    }
    link_touching(cut_pieces);
    std::vector<Chain> all = chains(cut_pieces.pieces);
    // Single small pieces are noise, and would only slow the search down.
    std::erase_if(all, [&](const Chain& chain) {
        return chain.pieces.size() == 1
            && cut_pieces.pieces[static_cast<std::size_t>(chain.pieces[0])].voxels.size() < 20;
    });
    bridge(cut_pieces.pieces, all);
    std::vector<RibTrack> ribs;
    for (const Chain& chain : all) {
        RibTrack rib;
        rib.left = chain.left;
        const std::size_t bony = bony_pieces(cut_pieces.pieces, chain);
        for (std::size_t at = 0; at < bony; ++at) {
            const Piece& piece = cut_pieces.pieces[static_cast<std::size_t>(chain.pieces[at])];
            rib.line.push_back(piece.centre);
            if (at > 0 && piece.before != chain.pieces[at - 1])
                rib.bridged_mm = std::max(rib.bridged_mm, (piece.centre - rib.line[at - 1]).norm() - kPieceLength);
            rib.angle.push_back((piece.sector + 0.5) * kSectorDeg);
            rib.voxels.insert(rib.voxels.end(), piece.voxels.begin(), piece.voxels.end());
        }
        straighten(rib.line);
        // The last rib may leave the image soon after its beginning.
        const bool leaves = !rib.line.empty() && rib.line.back().z() < image.grid.origin.z() + kBorder;
        if (length(rib) >= (leaves ? kShortestLeaving : kShortest) && runs_like_a_rib(rib))
            ribs.push_back(std::move(rib));
    }
    return ribs;
}

} // namespace retractor::datasets::segmentation
