#include "fem/interactive/condensed_body.h"

#include "fem/interactive/vertex_matrix.h"
#include "fem/linear_algebra/dense_algebra.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <string>
#include <utility>

namespace retractor::fem {

namespace {

    std::string vertex_name(VertexId v) { return "vertex " + std::to_string(v); }

} // namespace

CondensedBody::CondensedBody(
    const OnlineStiffness& stiffness, const std::vector<std::uint8_t>& fixed, const std::vector<VertexId>& kept)
    : kept_(kept)
    , planned_(kept.size())
{
    const OnlineStiffness& K = stiffness;
    const auto is_fixed = [&](VertexId v) {
        return static_cast<std::size_t>(v) < fixed.size() && fixed[static_cast<std::size_t>(v)] != 0;
    };
    place_.assign(K.slot_count(), -1);
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const VertexId v = kept[i];
        if (v < 0 || static_cast<std::size_t>(v) >= K.slot_count() || !K.alive(v) || is_fixed(v) || place(v) >= 0)
            throw InputError("a vertex to keep is not alive, is fixed, or is named twice", vertex_name(v));
        place_[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(i);
    }
    number_.assign(K.slot_count(), -1);
    for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
        if (K.alive(v) && !is_fixed(v) && place(v) < 0)
            free_.push_back(v);
    const std::size_t kept_from = free_.size();
    free_.insert(free_.end(), kept.begin(), kept.end());
    for (std::size_t i = 0; i < free_.size(); ++i)
        number_[static_cast<std::size_t>(free_[i])] = static_cast<std::int32_t>(i);
    {
        const auto row = [&](VertexId v) -> const OnlineStiffness::Row& { return K.row(v); };
        const auto number = [&](VertexId v) { return number_[static_cast<std::size_t>(v)]; };
        SparseMatrix matrix = vertex_matrix(row, free_, number);
        factor_.analyse_in_order(
            std::move(matrix.pattern), condensing_order(row, free_, number, kept_from, Ordering::nested_dissection));
        try {
            factor_.factorise(matrix.values);
        } catch (const SolverError& error) {
            if (const std::int32_t unknown = factor_.failed_unknown(); unknown >= 0)
                throw SolverError(std::string("stiffness: ") + error.what(),
                    vertex_name(free_[static_cast<std::size_t>(unknown / 3)]) + ", axis " + "xyz"[unknown % 3]);
            throw;
        }
    }
    factor_.keep_factor_only();
    Eigen::MatrixXd compliance = factor_.trailing_factor(3 * static_cast<Eigen::Index>(kept.size()));
    stiffness_ = times_own_transpose(compliance);
    invert_from_factor(compliance);
    compliance_ = std::make_shared<const Eigen::MatrixXd>(std::move(compliance));
}

AddedVertices CondensedBody::keep_also(const std::vector<VertexId>& vertices)
{
    std::vector<VertexId> fresh;
    for (const VertexId v : vertices) {
        if (!has(v))
            throw InputError("a vertex to keep is not a free vertex of the body", vertex_name(v));
        if (place(v) >= 0)
            continue;
        place_[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(kept_.size() + fresh.size());
        fresh.push_back(v);
    }
    AddedVertices hanging { kept_, fresh, {}, {} };
    if (fresh.empty())
        return hanging;
    constexpr Eigen::Index kTogether = 24; // right sides per solve; BLAS is at full speed and the work space small
    const auto unknowns = 3 * static_cast<Eigen::Index>(free_.size());
    const auto added = 3 * static_cast<Eigen::Index>(fresh.size()), old = stiffness_.rows();
    Eigen::MatrixXd fields(unknowns, added);
    for (Eigen::Index from = 0; from < added; from += kTogether) {
        const Eigen::Index columns = std::min(kTogether, added - from);
        Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(unknowns, columns);
        for (Eigen::Index c = 0; c < columns; ++c)
            unit(
                3 * number_[static_cast<std::size_t>(fresh[static_cast<std::size_t>((from + c) / 3)])] + (from + c) % 3,
                c)
                = 1.0;
        fields.middleCols(from, columns) = factor_.solve(unit);
    }
    factor_.keep_factor_only();
    kept_.insert(kept_.end(), fresh.begin(), fresh.end());

    const auto rows_of_kept = [&](Eigen::Index count, Eigen::Index from) {
        Eigen::MatrixXd rows(count, added);
        for (Eigen::Index i = 0; i < count; ++i)
            rows.row(i) = fields.row(
                3 * number_[static_cast<std::size_t>(kept_[static_cast<std::size_t>((from + i) / 3)])] + i % 3);
        return rows;
    };
    const Eigen::MatrixXd C_ox = rows_of_kept(old, 0), C_xx = rows_of_kept(added, old);
    const Eigen::MatrixXd SC = product(stiffness_, C_ox); // old rows, added columns
    Eigen::MatrixXd S_xx = C_xx - product_transposed(C_ox, SC);
    hanging.follow = SC.transpose();
    hanging.own = S_xx;
    invert_positive_definite(S_xx, "the compliance of the vertices that were added");
    const Eigen::MatrixXd S_ox = -product(SC, S_xx);
    Eigen::MatrixXd S(old + added, old + added), C(old + added, old + added);
    S.topLeftCorner(old, old) = stiffness_ - product(S_ox, Eigen::MatrixXd(SC.transpose()));
    S.topRightCorner(old, added) = S_ox;
    S.bottomLeftCorner(added, old) = S_ox.transpose();
    S.bottomRightCorner(added, added) = S_xx;
    C.topLeftCorner(old, old) = *compliance_;
    C.topRightCorner(old, added) = C_ox;
    C.bottomLeftCorner(added, old) = C_ox.transpose();
    C.bottomRightCorner(added, added) = C_xx;
    stiffness_ = std::move(S);
    compliance_ = std::make_shared<const Eigen::MatrixXd>(std::move(C));
    const Eigen::Index had = added_fields_.cols();
    RETRACTOR_ASSERT(stiffness_.rows() == 3 * static_cast<Eigen::Index>(kept_.size()));
    added_fields_.conservativeResize(unknowns, had + added);
    added_fields_.rightCols(added) = fields;
    return hanging;
}

Eigen::VectorXd CondensedBody::solve(const Eigen::VectorXd& load) const
{
    RETRACTOR_ASSERT(load.size() >= 3 * static_cast<Eigen::Index>(number_.size()));
    Eigen::MatrixXd packed(3 * static_cast<Eigen::Index>(free_.size()), 1);
    for (std::size_t i = 0; i < free_.size(); ++i)
        packed.col(0).segment<3>(3 * static_cast<Eigen::Index>(i)) = load.segment<3>(3 * free_[i]);
    const Eigen::MatrixXd solution = factor_.solve(packed);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(load.size());
    for (std::size_t i = 0; i < free_.size(); ++i)
        x.segment<3>(3 * free_[i]) = solution.col(0).segment<3>(3 * static_cast<Eigen::Index>(i));
    return x;
}

Eigen::MatrixXd CondensedBody::field(const Eigen::MatrixXd& kept_displacement, std::size_t slots) const
{
    RETRACTOR_ASSERT(kept_displacement.rows() == 3 * static_cast<Eigen::Index>(kept_.size()));
    RETRACTOR_ASSERT(slots >= number_.size());
    const auto planned = 3 * static_cast<Eigen::Index>(planned_), added = kept_displacement.rows() - planned;
    const auto unknowns = 3 * static_cast<Eigen::Index>(free_.size());
    Eigen::MatrixXd x(unknowns, kept_displacement.cols());
    x.bottomRows(planned) = kept_displacement.topRows(planned);
    if (added > 0) { // forces on the added vertices give their displacements; the fields of these forces are known
        const Eigen::MatrixXd forces = product(Eigen::MatrixXd(stiffness_.bottomRows(added)), kept_displacement);
        x.bottomRows(planned) -= product(Eigen::MatrixXd(compliance_->topRightCorner(planned, added)), forces);
        factor_.fill_from_trailing(planned, x);
        x += product(added_fields_, forces);
    } else {
        factor_.fill_from_trailing(planned, x);
    }
    Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(slots), x.cols());
    for (Eigen::Index c = 0; c < x.cols(); ++c)
        for (std::size_t i = 0; i < free_.size(); ++i)
            whole.col(c).segment<3>(3 * free_[i]) = x.col(c).segment<3>(3 * static_cast<Eigen::Index>(i));
    return whole;
}

std::size_t CondensedBody::bytes() const
{
    return factor_.bytes()
        + static_cast<std::size_t>(stiffness_.size() + compliance_->size() + added_fields_.size()) * sizeof(double)
        + (free_.size() + number_.size() + place_.size() + kept_.size()) * sizeof(std::int32_t);
}

} // namespace retractor::fem
