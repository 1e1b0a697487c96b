#include "ui/scene/vtk/identifier_picture.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

namespace retractor::ui {

namespace {

    /// Colours are numbers with three digits of base 6; black is the background.
    constexpr int kLevels = 6, kLevelStep = 51;
    constexpr int kMostStructures = kLevels * kLevels * kLevels - 1;

    Color color_of(int structure)
    {
        const int n = structure + 1;
        const auto level = [](int digit) { return digit * kLevelStep / 255.0; };
        return { level(n / (kLevels * kLevels)), level(n / kLevels % kLevels), level(n % kLevels) };
    }

    /// The structure of a pixel; -1 for the background and for mixed colours at edges.
    int structure_of(const std::uint8_t* rgb)
    {
        constexpr int kTolerance = 4; // of 255: rounding
        int n = 0;
        for (int c = 0; c < 3; ++c) {
            const int digit = (rgb[c] + kLevelStep / 2) / kLevelStep;
            if (std::abs(rgb[c] - digit * kLevelStep) > kTolerance)
                return -1;
            n = kLevels * n + digit;
        }
        return n - 1;
    }

    Scene bare_scene(const Camera& camera)
    {
        Scene bare;
        bare.camera = camera;
        bare.orientation_marker = bare.scale_bar = false;
        bare.background_low = bare.background_high = { 0.0, 0.0, 0.0 };
        return bare;
    }

    bool hides(const SurfaceItem& item)
    {
        return !item.on_top && item.opacity >= 1.0 && item.mesh != nullptr && !item.mesh->triangles.empty();
    }

    SurfaceItem plain(const SurfaceItem& item, const Color& color)
    {
        return {
            .name = item.name, .mesh = item.mesh, .look = { .color = color, .finish = Finish::unlit }, .smooth = false
        };
    }

    Image render(OffscreenRenderer& renderer, Scene scene, int width, int height)
    {
        Picture picture { .width = width, .height = height, .viewports = {} };
        picture.viewports.push_back({ .scene = std::move(scene) });
        return renderer.render(picture);
    }

    /// A camera at the same eye that holds all of the target.
    Camera camera_on_target(const Scene& scene)
    {
        Camera camera = scene.camera;
        const Vec3 sight = (camera.aim - camera.eye).normalized();
        double widest = 0.0; // tangent of the angle off the line of sight
        for (const SurfaceItem& item : scene.surfaces)
            for (Eigen::Index v = 0; item.target && v < item.mesh->vertices.rows(); ++v) {
                const Vec3 line = Vec3(item.mesh->vertices.row(v).transpose()) - camera.eye;
                const double along = line.dot(sight);
                if (along > 0.0)
                    widest = std::max(widest, (line - along * sight).norm() / along);
            }
        constexpr double kMargin = 1.05;
        camera.view_angle_deg = 2.0 * std::atan(kMargin * widest) * 180.0 / std::numbers::pi;
        return camera;
    }

    /// For each pixel the distance to the nearest pixel of another structure or to the border, in steps to the four
    /// neighbours.
    std::vector<int> distances_to_edge(const IdentifierPicture& picture)
    {
        const int w = picture.width, h = picture.height;
        std::vector<int> distance(picture.structure.size(), 0);
        const auto at = [&](int x, int y) {
            return static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x);
        };
        const auto step = [&](int x, int y, int from_x, int from_y) {
            const bool inside = from_x >= 0 && from_y >= 0 && from_x < w && from_y < h;
            return inside && picture.structure[at(from_x, from_y)] == picture.structure[at(x, y)]
                ? distance[at(from_x, from_y)] + 1
                : 1;
        };
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x)
                distance[at(x, y)] = std::min(step(x, y, x - 1, y), step(x, y, x, y - 1));
        for (int y = h; y-- > 0;)
            for (int x = w; x-- > 0;)
                distance[at(x, y)] = std::min({ distance[at(x, y)], step(x, y, x + 1, y), step(x, y, x, y + 1) });
        return distance;
    }

    /// The place of a pixel's middle in the plane of the camera's aim.
    Vec3 place_of(const Camera& camera, double column, double row, int width, int height)
    {
        const Vec3 sight = (camera.aim - camera.eye).normalized(), right = sight.cross(camera.up).normalized();
        const double slope = std::tan(0.5 * camera.view_angle_deg * std::numbers::pi / 180.0);
        const double half_height = camera.parallel ? camera.half_height_mm : slope * (camera.aim - camera.eye).norm();
        const double x = (2.0 * column + 1.0 - width) / height, y = 1.0 - (2.0 * row + 1.0) / height;
        return camera.aim + half_height * (x * right + y * right.cross(sight));
    }

    struct Word {
        int x = 0, y = 0, width_px = 0, structure = 0, room = 0;
    };

    /// Whether the middle of a word of this width may stand at a pixel: the word lies in the picture, and covers
    /// neither title, legend nor scale.
    bool may_stand(const Scene& scene, const IdentifierPicture& picture, int x, int y, int width_px)
    {
        constexpr double kLegendLine = 0.036; // of the picture's height, at most
        const double legend = kLegendLine * static_cast<double>(scene.legend.size());
        constexpr double kTitle = 0.07, kScale = 0.12, kScaleWidth = 0.3; // of the picture's height and width
        const int left = x - width_px / 2, right = x + width_px / 2;
        if (left < 0 || right > picture.width)
            return false;
        const bool by_title = y < kTitle * picture.height && left < picture.width / 2;
        const bool by_legend = y < (kTitle + legend) * picture.height && left < scene.legend_share * picture.width;
        const bool by_scale = y > (1.0 - kScale) * picture.height && left < kScaleWidth * picture.width;
        return !by_title && !by_legend && !by_scale;
    }

    /// Whether a slice shows a place of its plane.
    bool shows(const SliceItem& slice, const Vec3& place)
    {
        if (!slice.oblique)
            return true; // as far as the image goes
        const Vec3 offset = place - slice.point;
        return std::abs(slice.oblique->right.dot(offset)) <= slice.oblique->half_width_mm
            && std::abs(slice.oblique->up.dot(offset)) <= slice.oblique->half_height_mm;
    }

} // namespace

IdentifierPicture identifier_picture(OffscreenRenderer& renderer, const Scene& scene,
    const std::map<Label, std::string>& label_names, int width, int height)
{
    IdentifierPicture picture { .width = width, .height = height, .names = {}, .structure = {} };
    const auto number_of = [&](const std::string& name) {
        const auto found = std::find(picture.names.begin(), picture.names.end(), name);
        if (found != picture.names.end())
            return static_cast<int>(found - picture.names.begin());
        picture.names.push_back(name);
        return static_cast<int>(picture.names.size()) - 1;
    };
    Scene plain_scene = bare_scene(scene.camera);
    for (const SurfaceItem& item : scene.surfaces) {
        if (!hides(item))
            continue;
        SurfaceItem drawn = plain(item, {});
        if (item.look_of_label.empty()) {
            drawn.look.color = color_of(number_of(item.name));
        } else {
            for (const auto& [label, look] : item.look_of_label) {
                const auto name = label_names.find(label);
                const int number = number_of(name != label_names.end() ? name->second : item.name);
                drawn.look_of_label[label] = { .color = color_of(number), .finish = Finish::unlit };
            }
        }
        plain_scene.surfaces.push_back(std::move(drawn));
    }
    if (picture.names.size() > static_cast<std::size_t>(kMostStructures))
        throw InputError("a picture can tell " + std::to_string(kMostStructures) + " structures apart, not "
            + std::to_string(picture.names.size()));
    const Image image = render(renderer, std::move(plain_scene), width, height);
    for (std::size_t p = 0; p + 2 < image.rgb.size(); p += 3)
        picture.structure.push_back(structure_of(&image.rgb[p]));
    RETRACTOR_ASSERT(picture.structure.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    return picture;
}

IdentifierPicture identifier_picture(const SliceItem& slice, const Camera& camera,
    const std::map<Label, std::string>& label_names, int width, int height)
{
    IdentifierPicture picture { .width = width, .height = height, .names = {}, .structure = {} };
    std::map<Label, int> number_of;
    for (const auto& [label, name] : label_names) {
        number_of[label] = static_cast<int>(picture.names.size());
        picture.names.push_back(name);
    }
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            const Vec3 place = place_of(camera, column, row, width, height);
            const Label label
                = slice.labels == nullptr || !shows(slice, place) ? Label { 0 } : mesh::label_at(*slice.labels, place);
            const auto number = number_of.find(label);
            picture.structure.push_back(number != number_of.end() ? number->second : -1);
        }
    return picture;
}

TargetPixels target_pixels(OffscreenRenderer& renderer, const Scene& scene, int pixels)
{
    constexpr Color kWhite { 1.0, 1.0, 1.0 }, kBlack { 0.0, 0.0, 0.0 };
    if (std::none_of(scene.surfaces.begin(), scene.surfaces.end(),
            [](const SurfaceItem& item) { return item.target && hides(item); }))
        return {};
    Scene alone = bare_scene(camera_on_target(scene));
    for (const SurfaceItem& item : scene.surfaces)
        if (item.target && hides(item))
            alone.surfaces.push_back(plain(item, kWhite));
    Scene all = alone;
    for (const SurfaceItem& item : scene.surfaces)
        if (!item.target && hides(item))
            all.surfaces.push_back(plain(item, kBlack));
    const auto lit = [&](Scene counted) {
        const Image image = render(renderer, std::move(counted), pixels, pixels);
        std::size_t count = 0;
        for (std::size_t i = 0; i < image.rgb.size(); i += 3)
            count += image.rgb[i] > 127 ? 1 : 0;
        return count;
    };
    return { .visible = lit(std::move(all)), .alone = lit(std::move(alone)) };
}

void add_names(Scene& scene, const IdentifierPicture& picture)
{
    // Of the picture's height: a structure must have this room for its name, and letters have this size.
    constexpr double kRoom = 0.006, kLetter = 0.0145, kLine = 0.03;
    constexpr double kRoomOfWidth = 0.05; // a long name on a speck of its structure would name what lies round it
    const std::vector<int> distance = distances_to_edge(picture);
    std::vector<Word> words(picture.names.size());
    for (std::size_t n = 0; n < words.size(); ++n)
        words[n].width_px
            = static_cast<int>(kLetter * picture.height * static_cast<double>(readable(picture.names[n]).size()));
    for (std::size_t p = 0; p < distance.size(); ++p) {
        const int structure = picture.structure[p];
        if (structure < 0 || structure >= static_cast<int>(words.size()))
            continue;
        Word& word = words[static_cast<std::size_t>(structure)];
        const int x = static_cast<int>(p % static_cast<std::size_t>(picture.width)),
                  y = static_cast<int>(p / static_cast<std::size_t>(picture.width));
        if (distance[p] > word.room && may_stand(scene, picture, x, y, word.width_px))
            word = { .x = x, .y = y, .width_px = word.width_px, .structure = structure, .room = distance[p] };
    }
    std::sort(words.begin(), words.end(), [](const Word& a, const Word& b) { return a.room > b.room; });
    std::vector<Word> placed;
    for (Word& word : words) {
        if (word.room < kRoom * picture.height)
            break;
        if (word.room < kRoomOfWidth * word.width_px)
            continue;
        const std::string text = readable(picture.names[static_cast<std::size_t>(word.structure)]);
        const bool covers = std::any_of(placed.begin(), placed.end(), [&](const Word& other) {
            return std::abs(word.y - other.y) < kLine * picture.height
                && 2 * std::abs(word.x - other.x) < word.width_px + other.width_px;
        });
        if (covers)
            continue;
        placed.push_back(word);
        scene.words.push_back({ .text = text,
            .position = place_of(scene.camera, word.x, word.y, picture.width, picture.height),
            .color = { 1.0, 1.0, 1.0 } });
    }
}

} // namespace retractor::ui
