#include "planner/measures/sight/aperture.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace retractor::planner {

namespace {

    constexpr double kLeastMm = 1e-6;
    /// Pieces of a bent line leave wedges between their planes; a ray in a wedge belongs to both pieces.
    constexpr double kWedgeMm = 0.5;

    /// Width of the hole at a section, as a share of that in the middle; not quite 0 at the ends.
    double share_of_width(std::size_t n, std::size_t sections)
    {
        const double t = 2.0 * static_cast<double>(n) / static_cast<double>(sections - 1) - 1.0;
        return 1.0 - t * t + kLeastMm;
    }

    /// The middle of the hole, and a plane that fits it.
    OpeningGeometry opening_of(const std::vector<ApertureSection>& sections, double length_mm, double width_mm)
    {
        OpeningGeometry opening;
        opening.width_mm = width_mm;
        opening.incision_length_mm = length_mm;
        opening.start = sections.front().skin;
        opening.end = sections.back().skin;
        opening.length_mm = (opening.end - opening.start).norm();
        opening.area_mm2 = 2.0 / 3.0 * width_mm * length_mm; // of a lens between two parabolas
        Vec3 outward = Vec3::Zero();
        double weights = 0.0;
        opening.centre = Vec3::Zero();
        for (std::size_t n = 0; n < sections.size(); ++n) {
            const double weight = share_of_width(n, sections.size());
            opening.centre += weight * sections[n].skin;
            outward += weight * (sections[n].skin - sections[n].inner).normalized();
            weights += weight;
        }
        opening.centre /= weights;
        opening.along = (opening.end - opening.start).normalized();
        opening.normal = (outward - opening.along.dot(outward) * opening.along).normalized();
        return opening;
    }

} // namespace

double thickness_at_aperture(const std::vector<ApertureSection>& sections)
{
    RETRACTOR_ASSERT(!sections.empty());
    if (sections.size() == 1)
        return (sections.front().skin - sections.front().inner).norm();
    double sum = 0.0, weights = 0.0;
    for (std::size_t n = 0; n < sections.size(); ++n) {
        const double weight = share_of_width(n, sections.size());
        sum += weight * (sections[n].skin - sections[n].inner).norm();
        weights += weight;
    }
    return sum / weights;
}

Aperture::Lens Aperture::lens_of(const std::vector<ApertureSection>& sections, bool skin, double width_mm)
{
    Lens lens;
    lens.width_mm = width_mm;
    const auto place = [&](std::size_t n) { return skin ? sections[n].skin : sections[n].inner; };
    for (std::size_t n = 0; n + 1 < sections.size(); ++n) {
        Piece piece;
        piece.start = place(n);
        piece.length_mm = (place(n + 1) - place(n)).norm();
        piece.from_mm = lens.length_mm;
        const Vec3 outward = sections[n].skin - sections[n].inner + sections[n + 1].skin - sections[n + 1].inner;
        if (!(piece.length_mm > kLeastMm))
            throw InputError("two sections of an aperture coincide", "section " + std::to_string(n));
        piece.along = (place(n + 1) - place(n)) / piece.length_mm;
        piece.normal = outward - piece.along.dot(outward) * piece.along;
        if (!(piece.normal.norm() > kLeastMm))
            throw InputError("the wall at an aperture has no thickness", "section " + std::to_string(n));
        piece.normal.normalize();
        piece.across = piece.normal.cross(piece.along);
        lens.length_mm += piece.length_mm;
        lens.pieces.push_back(piece);
    }
    return lens;
}

Aperture::Aperture(const std::vector<ApertureSection>& sections, const ApertureWidth& width)
{
    if (sections.size() < 2)
        throw InputError("an aperture needs at least two sections, got " + std::to_string(sections.size()));
    if (!(width.skin_mm > 0.0 && std::isfinite(width.skin_mm)))
        throw InputError("an aperture's width must be above 0 mm, got " + std::to_string(width.skin_mm));
    if (!std::isfinite(width.inner_mm))
        throw InputError("an aperture's width on the inner side is not a number");
    lenses_ = { lens_of(sections, true, width.skin_mm), lens_of(sections, false, width.inner_mm) };
    opening_ = opening_of(sections, lenses_[0].length_mm, width.skin_mm);
}

bool Aperture::Lens::passes(const Vec3& from, const Vec3& direction) const
{
    return std::ranges::any_of(pieces, [&](const Piece& piece) {
        const double slope = piece.normal.dot(direction);
        if (std::abs(slope) < kLeastMm)
            return false;
        const Vec3 at = from + piece.normal.dot(piece.start - from) / slope * direction - piece.start;
        const double along = piece.along.dot(at);
        if (along < -kWedgeMm || along > piece.length_mm + kWedgeMm)
            return false;
        const double t = 2.0 * (piece.from_mm + along) / length_mm - 1.0;
        return std::abs(piece.across.dot(at)) < 0.5 * width_mm * (1.0 - t * t);
    });
}

bool Aperture::passes(const Vec3& from, const Vec3& direction) const
{
    return lenses_[0].passes(from, direction) && lenses_[1].passes(from, direction);
}

double Aperture::distance_to_skin(const Vec3& from, const Vec3& direction) const
{
    const double slope = opening_.normal.dot(direction);
    return std::abs(slope) < kLeastMm ? 0.0 : std::max(0.0, opening_.normal.dot(opening_.centre - from) / slope);
}

} // namespace retractor::planner
