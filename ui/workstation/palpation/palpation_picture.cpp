#include "ui/workstation/palpation/palpation_picture.h"

#include "mesh/base/assert.h"
#include "mesh/base/statistics.h"
#include "planner/session/touched_surface.h"
#include "ui/scene/tissue_colors.h"
#include "ui/workstation/palpation/strip_chart.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace retractor::ui {

namespace {

    /// Number of shades by stiffness. A shade is half an octave, from an eighth to eight times the usual modulus.
    constexpr int kShades = 13, kUsualShade = 6;
    constexpr double kShownShaftMm = 140.0; ///< a longer shaft would end before the eye
    constexpr Color kStiff { 0.98, 0.90, 0.62 }, kSoft { 0.42, 0.32, 0.62 };
    constexpr Color kMarkColor { 0.35, 0.95, 1.0 };

    Color mixed(const Color& a, const Color& b, double share)
    {
        return { a.r + share * (b.r - a.r), a.g + share * (b.g - a.g), a.b + share * (b.b - a.b) };
    }

    Look look_of(const std::string& name)
    {
        if (name == "sheet")
            return { { 0.72, 0.30, 0.26 }, Finish::wet, 0.3 };
        return organ_look(name);
    }

    Look shaded(const Look& look, int shade)
    {
        Look made = look;
        const double share = 0.75 * std::abs(shade - kUsualShade) / kUsualShade;
        made.color = mixed(look.color, shade < kUsualShade ? kSoft : kStiff, share);
        return made;
    }

    /// What a finger cannot reach is dark.
    Look out_of_reach(const Look& look)
    {
        constexpr Color kDark { 0.10, 0.12, 0.18 };
        Look made = look;
        made.color = mixed(look.color, kDark, 0.72);
        return made;
    }

    Color color_of(std::size_t finger)
    {
        const QColor c = finger_color(finger);
        return { c.redF(), c.greenF(), c.blueF() };
    }

    /// Colour of a sphere: bright at a finger, and in deeper layers the organ's colour.
    Color sphere_color(const Color& organ, int layer)
    {
        if (layer < 0)
            return organ;
        return mixed(organ, { 1.0, 0.95, 0.45 }, 1.0 / (1.0 + 0.5 * layer));
    }

    std::map<Label, double> mean_modulus(const datasets::ElasticModel& body)
    {
        std::map<Label, std::pair<double, double>> sums;
        for (std::size_t t = 0; t < body.youngs_modulus.size(); ++t) {
            auto& [sum, count] = sums[t < body.mesh.labels.size() ? body.mesh.labels[t] : Label {}];
            sum += body.youngs_modulus[t];
            count += 1.0;
        }
        std::map<Label, double> means;
        for (const auto& [label, sum] : sums)
            means[label] = sum.first / sum.second;
        return means;
    }

} // namespace

Scene palpation_scene(const datasets::PalpationScene& scene, const std::vector<std::string>& notes)
{
    Scene picture;
    picture.title = scene.name;
    picture.notes = notes;
    const Points& p = scene.body.mesh.vertices;
    const Box box { p.colwise().minCoeff().transpose(), p.colwise().maxCoeff().transpose() };
    Vec3 outward = Vec3::Zero();
    for (const datasets::TouchSite& site : scene.sites)
        if (!site.name.ends_with("-opposite"))
            outward += site.outward;
    constexpr double kAgree = 0.1; // sites on all sides have no common direction
    outward = outward.norm() > kAgree ? Vec3(outward.normalized()) : Vec3(-Vec3::UnitY());
    Vec3 aside = outward.cross(Vec3::UnitZ());
    if (aside.norm() < 0.3)
        aside = outward.cross(Vec3::UnitX());
    const Vec3 look = -(outward + 0.4 * aside.normalized()).normalized();
    picture.camera = camera_for_box(box, look, std::abs(look.z()) > 0.8 ? Vec3(Vec3::UnitY()) : Vec3(Vec3::UnitZ()));
    const double off = 0.02 * (box.high - box.low).norm();
    for (const datasets::TouchSite& site : scene.sites)
        if (!site.name.ends_with("-opposite"))
            picture.words.push_back({ site.name, site.point + off * site.outward, { 0.9, 0.95, 1.0 } });
    return picture;
}

std::array<Vec3, haptics::kMaxFingers> shown_fingertips(const planner::PalpationFrame& frame)
{
    RETRACTOR_ASSERT(frame.servo.finger_count <= haptics::kMaxFingers);
    std::array<Vec3, haptics::kMaxFingers> shown;
    for (std::size_t f = 0; f < frame.servo.finger_count; ++f) {
        const haptics::FingerContact& contact = frame.servo.contacts[f];
        const haptics::Fingertip& tip = frame.servo.fingers[f];
        shown[f] = tip.position;
        if (contact.stopped) { // the hand has gone on, the finger has not
            shown[f] = contact.stopped_at;
            continue;
        }
        if (!contact.touching)
            continue;
        // Where the tissue holds the fingertip, it is shown at the bottom of its dent, not inside.
        const bool held_back = (contact.proxy - tip.position).dot(contact.normal) >= contact.depth;
        const Vec3 from = held_back ? Vec3(contact.proxy - contact.depth * contact.normal) : tip.position;
        shown[f] = planner::seated_on(frame.shown, frame.surface->triangles, from, tip.radius, contact.normal);
    }
    return shown;
}

PalpationPicture::PalpationPicture(const datasets::PalpationScene& scene, const std::vector<std::string>& organs)
    : name_(scene.name)
    , organs_(organs)
    , modulus_of_(mean_modulus(scene.body))
    , usual_modulus_(upper_median(std::vector<double>(scene.body.youngs_modulus)))
{
}

int PalpationPicture::shade_of(
    const TriMesh& surface, std::size_t triangle, const std::vector<haptics::ElasticTemplate>& edits) const
{
    RETRACTOR_ASSERT(triangle < surface.triangles.size());
    RETRACTOR_ASSERT(surface.labels.empty() || surface.labels.size() == surface.triangles.size());
    const Label label = surface.labels.empty() ? Label {} : surface.labels[triangle];
    const auto found = modulus_of_.find(label);
    double modulus = found != modulus_of_.end() ? found->second : usual_modulus_;
    Vec3 centre = Vec3::Zero();
    for (const VertexId v : surface.triangles[triangle])
        centre += surface.vertices.row(v).transpose() / 3.0;
    for (const haptics::ElasticTemplate& edit : edits)
        if (edit.youngs_modulus && edit.contains(centre))
            modulus = *edit.youngs_modulus;
    const int shade = kUsualShade + static_cast<int>(std::lround(2.0 * std::log2(modulus / usual_modulus_)));
    return std::clamp(shade, 0, kShades - 1);
}

void PalpationPicture::show_surface(const planner::PalpationFrame& frame, const PalpationViewOptions& options)
{
    RETRACTOR_ASSERT(frame.surface != nullptr);
    const TriMesh& surface = *frame.surface;
    if (surface_ != frame.surface || hidden_ != options.hidden_organs || edits_ != options.edits
        || spheres_ != options.spheres || reached_ != frame.reached) {
        surface_ = frame.surface;
        reached_ = frame.reached;
        hidden_ = options.hidden_organs;
        edits_ = options.edits;
        spheres_ = options.spheres;
        LiveTopology topology;
        topology.rest = surface.vertices;
        if (organs_.empty())
            for (int shade = 0; shade < kShades; ++shade)
                topology.looks.push_back(shaded(look_of(name_), shade));
        for (const std::string& organ : organs_)
            topology.looks.push_back(look_of(organ));
        // Behind these looks stand the same, out of reach.
        const auto looks = static_cast<int>(topology.looks.size());
        for (int l = 0; l < looks && reached_ != nullptr; ++l)
            topology.looks.push_back(out_of_reach(topology.looks[static_cast<std::size_t>(l)]));
        for (std::size_t t = 0; t < surface.triangles.size() && !options.spheres; ++t) {
            const Label label = surface.labels.empty() ? Label { 1 } : surface.labels[t];
            if (!organs_.empty() && hidden_.contains(label))
                continue;
            topology.triangles.push_back(surface.triangles[t]);
            topology.look_of.push_back(organs_.empty()
                    ? shade_of(surface, t, options.edits)
                    : std::clamp(static_cast<int>(label) - 1, 0, static_cast<int>(organs_.size()) - 1));
            if (reached_ != nullptr && t < reached_->size() && (*reached_)[t] == 0)
                topology.look_of.back() += looks;
        }
        live_.surface().set_topology(topology);
    }
    live_.surface().set_positions(frame.shown);
}

void PalpationPicture::show_spheres(const planner::PalpationFrame& frame, const PalpationViewOptions& options)
{
    std::vector<ShownBall> balls;
    if (options.spheres && frame.spheres != nullptr)
        for (std::size_t i = 0; i < frame.spheres->radius.size(); ++i) {
            RETRACTOR_ASSERT(i < frame.spheres->organ.size() && i < frame.sphere_layers.size());
            RETRACTOR_ASSERT(static_cast<Eigen::Index>(i) < frame.sphere_centres.rows());
            const std::size_t organ = frame.spheres->organ[i];
            if (options.hidden_organs.contains(static_cast<Label>(organ + 1)))
                continue;
            balls.push_back({ frame.sphere_centres.row(static_cast<Eigen::Index>(i)).transpose(),
                frame.spheres->radius[i],
                sphere_color(look_of(organ < organs_.size() ? organs_[organ] : name_).color, frame.sphere_layers[i]) });
        }
    live_.set_spheres(balls);
}

void PalpationPicture::set_hands(const ShownHands& hands)
{
    hands_ = hands;
    for (std::size_t h = 0; h < hands_.size(); ++h)
        live_.set_hand(h, hands_[h].surface);
}

void PalpationPicture::show_hands(const PalpationViewOptions& options, const std::vector<haptics::ShownFinger>& fingers)
{
    if (!options.hands) {
        for (std::size_t h = 0; h < hands_.size(); ++h)
            live_.hide_hand(h);
        return;
    }
    if (hands_[0].surface.triangles.empty())
        for (std::size_t h = 0; h < hands_.size(); ++h) {
            hands_[h] = haptics::make_hand(h == 1);
            live_.set_hand(h, hands_[h].surface);
        }
    const auto places = haptics::place_hands(hands_, fingers, options.sight, options.up);
    for (std::size_t h = 0; h < hands_.size(); ++h)
        if (places[h])
            live_.place_hand(h, places[h]->turn, places[h]->shift);
        else
            live_.hide_hand(h);
}

void PalpationPicture::show(const planner::PalpationFrame& frame, const PalpationViewOptions& options)
{
    show_surface(frame, options);
    show_spheres(frame, options);
    const std::array<Vec3, haptics::kMaxFingers> at = shown_fingertips(frame);
    std::vector<ShownBall> tips;
    std::vector<haptics::ShownFinger> fingers;
    std::vector<ShownRod> rods;
    for (std::size_t f = 0; f < std::min(frame.servo.finger_count, planner::kMostFingers); ++f) {
        if (!options.fingers[f])
            continue;
        tips.push_back({ at[f], frame.servo.fingers[f].radius, color_of(f) });
        const haptics::FingerContact& contact = frame.servo.contacts[f];
        if (const double radius = frame.servo.fingers[f].radius; options.through_opening && !contact.outward.isZero()) {
            const haptics::StraightRod& finger = *options.through_opening;
            rods.push_back({ .tip = at[f],
                .outward = contact.outward,
                .tip_radius = radius,
                .radius = std::max(0.5 * finger.thickness_mm, radius),
                .taper = finger.taper_mm,
                .length = std::min(finger.reach_mm, kShownShaftMm),
                .color = mixed(color_of(f), { 0.92, 0.88, 0.82 }, 0.6) });
        }
        fingers.push_back(
            { at[f], frame.servo.fingers[f].radius, contact.touching ? contact.normal : Vec3(-options.sight) });
    }
    live_.set_fingertips(tips);
    live_.set_fingers(rods);
    show_hands(options, fingers);
    live_.set_marks(
        options.mark ? planner::outline_of(*options.mark) : std::vector<std::array<Vec3, 2>> {}, kMarkColor);
}

} // namespace retractor::ui
