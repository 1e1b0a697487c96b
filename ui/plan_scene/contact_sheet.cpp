#include "ui/plan_scene/contact_sheet.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "ui/plan_scene/label_surfaces.h"
#include "ui/scene/label_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace retractor::ui {

namespace {

    constexpr double kFont = 15.0, kLine = 1.4 * kFont; // pixels
    constexpr double kLegendWidth = 400.0, kHeader = 2.2 * kFont;
    /// Denser voxels are shown: tissue, and also the table, so that the removal of the table can be checked.
    constexpr int kSomethingHu = -500;
    constexpr double kMargin_mm = 10.0;

    struct Plane {
        SlicePlane plane;
        const char* name;
        int normal, across, upward;
        char axis;
    };
    constexpr std::array<Plane, 3> kPlanes { { { SlicePlane::axial, "axial", 2, 0, 1, 'z' },
        { SlicePlane::coronal, "coronal", 1, 0, 2, 'y' }, { SlicePlane::sagittal, "sagittal", 0, 1, 2, 'x' } } };

    // ---- what there is ---------------------------------------------------------------------------------------------

    struct IndexBox {
        std::array<int, 3> low, high; ///< inclusive
    };

    Box world_box(const mesh::ImageGrid& grid, const IndexBox& box)
    {
        Box world { Vec3::Constant(std::numeric_limits<double>::max()),
            Vec3::Constant(std::numeric_limits<double>::lowest()) };
        for (int corner = 0; corner < 8; ++corner) {
            Vec3 index;
            for (int a = 0; a < 3; ++a)
                index[a] = ((corner >> a) & 1) != 0 ? box.high[static_cast<std::size_t>(a)] + 0.5
                                                    : box.low[static_cast<std::size_t>(a)] - 0.5;
            const Vec3 p = grid.world(index);
            world.low = world.low.cwiseMin(p);
            world.high = world.high.cwiseMax(p);
        }
        return world;
    }

    template <typename Voxel, typename Keep>
    std::optional<Box> box_of(const mesh::ImageGrid& grid, const std::vector<Voxel>& voxels, Keep&& keep)
    {
        std::array<int, 3> low { grid.size[0], grid.size[1], grid.size[2] }, high { -1, -1, -1 };
        std::size_t at = 0;
        for (int k = 0; k < grid.size[2]; ++k)
            for (int j = 0; j < grid.size[1]; ++j)
                for (int i = 0; i < grid.size[0]; ++i, ++at)
                    if (keep(voxels[at])) {
                        low = { std::min(low[0], i), std::min(low[1], j), std::min(low[2], k) };
                        high = { std::max(high[0], i), std::max(high[1], j), std::max(high[2], k) };
                    }
        if (high[0] < 0)
            return std::nullopt;
        return world_box(grid, { low, high });
    }

    struct LabelCount {
        std::size_t voxels = 0;
        Vec3 index_sum = Vec3::Zero();
    };

    /// The data of the sheet.
    struct Content {
        std::shared_ptr<const mesh::Volume> image; ///< never null; black when there is no CT
        std::shared_ptr<const mesh::LabelVolume> labels;
        std::map<Label, LabelCount> counts; ///< labels that have voxels
        std::map<Label, Color> colors;
        Box shown; ///< region that the slices cover
        Box spread; ///< region over which the slices are spread
        bool has_ct = true;
    };

    std::map<Label, LabelCount> count_labels(const mesh::LabelVolume& labels)
    {
        std::vector<LabelCount> counts(static_cast<std::size_t>(std::numeric_limits<Label>::max()) + 1);
        std::size_t at = 0;
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i, ++at) {
                    LabelCount& count = counts[labels.voxels[at]];
                    ++count.voxels;
                    count.index_sum += Vec3(i, j, k);
                }
        std::map<Label, LabelCount> found;
        for (std::size_t id = 1; id < counts.size(); ++id)
            if (counts[id].voxels > 0)
                found.emplace(static_cast<Label>(id), counts[id]);
        return found;
    }

    std::shared_ptr<const mesh::Volume> black_image(const mesh::ImageGrid& grid)
    {
        constexpr std::int16_t kAir = -1024;
        auto image = std::make_shared<mesh::Volume>();
        image->grid = grid;
        image->voxels.assign(grid.voxel_count(), kAir);
        return image;
    }

    Content gather(std::shared_ptr<const mesh::Volume> ct, std::shared_ptr<const mesh::LabelVolume> labels)
    {
        if (ct == nullptr && labels == nullptr)
            throw InputError("a contact sheet needs a CT or labels");
        Content content;
        content.has_ct = ct != nullptr;
        content.labels = std::move(labels);
        content.image = ct != nullptr ? std::move(ct) : black_image(content.labels->grid);
        const mesh::Volume& image = *content.image;
        mesh::check_grid(image.grid);
        if (image.voxels.size() != image.grid.voxel_count())
            throw InputError("the image's voxel count does not match its size");
        std::optional<Box> labelled;
        if (content.labels != nullptr) {
            mesh::check_grid(content.labels->grid);
            if (content.labels->voxels.size() != content.labels->grid.voxel_count())
                throw InputError("the labels' voxel count does not match their size");
            content.counts = count_labels(*content.labels);
            content.colors = label_colors(content.labels->table);
            labelled = box_of(content.labels->grid, content.labels->voxels, [](Label label) { return label != 0; });
        }
        const auto dense = box_of(image.grid, image.voxels, [](std::int16_t hu) { return hu > kSomethingHu; });
        const Box whole = world_box(
            image.grid, { { 0, 0, 0 }, { image.grid.size[0] - 1, image.grid.size[1] - 1, image.grid.size[2] - 1 } });
        content.shown = dense ? *dense : labelled.value_or(whole);
        if (labelled) {
            content.shown.low = content.shown.low.cwiseMin(labelled->low);
            content.shown.high = content.shown.high.cwiseMax(labelled->high);
        }
        content.shown.low.array() -= kMargin_mm;
        content.shown.high.array() += kMargin_mm;
        content.spread = labelled ? *labelled : content.shown;
        return content;
    }

    std::optional<Vec3> focus_of(const Content& content, const ContactSheetOptions& options)
    {
        if (options.focus)
            return options.focus;
        if (content.labels == nullptr)
            return std::nullopt;
        for (const std::string_view name : { "aneurysm", "target", "heart", "aorta" })
            if (const mesh::LabelInfo* info = mesh::find_label(content.labels->table, name))
                if (const auto count = content.counts.find(info->id); count != content.counts.end())
                    return content.labels->grid.world(
                        count->second.index_sum / static_cast<double>(count->second.voxels));
        return std::nullopt;
    }

    /// Positions spread evenly. The position nearest to the focus moves onto the focus.
    std::vector<double> positions(double low, double high, int count, std::optional<double> focus)
    {
        std::vector<double> at;
        for (int n = 0; n < count; ++n)
            at.push_back(low + (high - low) * (n + 0.5) / count);
        if (focus && *focus > low && *focus < high) {
            const auto nearer = [&](double a, double b) { return std::abs(a - *focus) < std::abs(b - *focus); };
            *std::min_element(at.begin(), at.end(), nearer) = *focus;
        }
        return at;
    }

    // ---- words -----------------------------------------------------------------------------------------------------

    std::string millilitres_text(double ml) { return formatted(ml < 10.0 ? "%.1f ml" : "%.0f ml", ml); }

    /// The name of a row: "rib_left_" for "rib_left_5".
    std::string row_of(const std::string& name) { return name.substr(0, name.size() - level_of(name).size()); }

    LegendLine legend_line(const Content& content, const mesh::LabelInfo& info, const LabelCount& count, bool rough)
    {
        const double ml = static_cast<double>(count.voxels) * content.labels->grid.voxel_volume() / 1000.0;
        return { readable(info.name), (rough ? "rough, " : "") + millilitres_text(ml), content.colors.at(info.id) };
    }

    /// Lists every label that has voxels. When the lines do not fit, the ribs or vertebrae of a row share one line.
    std::vector<LegendLine> legend_of(const Content& content, const std::set<std::string>& rough, std::size_t fits)
    {
        std::vector<LegendLine> lines;
        if (content.labels == nullptr)
            return lines;
        const bool grouped = content.counts.size() > fits;
        std::map<std::string, std::size_t> line_of_row;
        for (const mesh::LabelInfo& info : content.labels->table) {
            const auto count = content.counts.find(info.id);
            if (count == content.counts.end())
                continue;
            const std::string level(level_of(info.name));
            if (!grouped || level.empty()) {
                lines.push_back(legend_line(content, info, count->second, rough.contains(info.name)));
                continue;
            }
            const auto [line, first] = line_of_row.try_emplace(row_of(info.name), lines.size());
            if (first)
                lines.push_back({ readable(row_of(info.name)), level, content.colors.at(info.id) });
            else
                lines[line->second].value += " " + level;
        }
        return lines;
    }

    /// Breaks the text at blanks into lines of at most `columns` letters. Continued lines are indented.
    std::vector<std::string> wrapped(const std::string& text, std::size_t columns)
    {
        std::vector<std::string> lines;
        std::string rest = text;
        while (rest.size() > columns) {
            std::size_t cut = rest.rfind(' ', columns);
            if (cut == std::string::npos || cut < columns / 2)
                cut = columns;
            lines.push_back(rest.substr(0, cut));
            rest = "    "
                + rest.substr(rest.find_first_not_of(' ', cut) == std::string::npos ? rest.size()
                                                                                    : rest.find_first_not_of(' ', cut));
        }
        lines.push_back(rest);
        return lines;
    }

    std::string grid_text(const char* what, const mesh::ImageGrid& grid)
    {
        return formatted("%s %d x %d x %d at %.3g x %.3g x %.3g mm", what, grid.size[0], grid.size[1], grid.size[2],
            grid.spacing.x(), grid.spacing.y(), grid.spacing.z());
    }

    std::string header_text(const Content& content, const ContactSheetOptions& options)
    {
        std::string text = options.title;
        if (content.has_ct) {
            text += "  |  " + grid_text("CT", content.image->grid)
                + formatted(", window %.0f to %.0f HU", options.level_hu - options.window_hu / 2.0,
                    options.level_hu + options.window_hu / 2.0);
        }
        if (content.labels != nullptr)
            text += "  |  " + grid_text("labels", content.labels->grid);
        return text + "  |  patient frame LPS";
    }

    // ---- slices ----------------------------------------------------------------------------------------------------

    /// Numbers of ribs and vertebrae on the slice, at the point of each section nearest to its middle.
    std::vector<TextItem> level_words(const Content& content, const Plane& plane, double at)
    {
        std::map<Label, std::string> levels;
        for (const mesh::LabelInfo& info : content.labels->table)
            if (const auto level = level_of(info.name); !level.empty())
                levels.emplace(info.id, level);
        if (levels.empty())
            return {};
        constexpr double kStep_mm = 2.0;
        std::map<Label, std::vector<Vec3>> sections;
        const Box& box = content.shown;
        for (double v = box.low[plane.upward]; v < box.high[plane.upward]; v += kStep_mm)
            for (double u = box.low[plane.across]; u < box.high[plane.across]; u += kStep_mm) {
                Vec3 p;
                p[plane.normal] = at;
                p[plane.across] = u;
                p[plane.upward] = v;
                if (const Label label = mesh::label_at(*content.labels, p); levels.contains(label))
                    sections[label].push_back(p);
            }
        std::vector<TextItem> words;
        for (const auto& [label, points] : sections) {
            Vec3 middle = Vec3::Zero();
            for (const Vec3& p : points)
                middle += p / static_cast<double>(points.size());
            const Vec3& nearest = *std::min_element(points.begin(), points.end(),
                [&](const Vec3& a, const Vec3& b) { return (a - middle).norm() < (b - middle).norm(); });
            words.push_back({ levels.at(label), nearest, { 1.0, 1.0, 1.0 } });
        }
        return words;
    }

    Scene slice_scene(const Content& content, const ContactSheetOptions& options, const Plane& plane, double at,
        double width, double height)
    {
        Scene scene;
        scene.title = formatted("%s  %c %.0f mm", plane.name, plane.axis, at);
        scene.font_px = kFont;
        scene.background_low = scene.background_high = { 0.0, 0.0, 0.0 };
        SliceItem slice;
        slice.image = content.image;
        slice.plane = plane.plane;
        slice.point = 0.5 * (content.shown.low + content.shown.high);
        slice.point[plane.normal] = at;
        slice.window_hu = options.window_hu;
        slice.level_hu = options.level_hu;
        if (content.labels != nullptr) {
            slice.labels = content.labels;
            slice.outline_of_label = content.colors;
            scene.words = level_words(content, plane, at);
        }
        slice.fill = content.has_ct ? 0.22 : 0.70;
        scene.camera = camera_for_slice(slice, content.shown, width / height);
        slice.pixel_mm = 2.0 * scene.camera.half_height_mm / height;
        scene.slices.push_back(std::move(slice));
        return scene;
    }

    // ---- views in space ----

    struct Side {
        const char* name;
        Vec3 sight;
    };

    /// Numbers of ribs and vertebrae at their points nearest to the eye.
    std::vector<TextItem> level_words(const std::vector<SurfaceItem>& surfaces, const Vec3& sight)
    {
        std::vector<TextItem> words;
        for (const SurfaceItem& item : surfaces) {
            const std::string_view level = level_of(item.name);
            const bool left = item.name.find("left") != std::string::npos;
            const bool right = item.name.find("right") != std::string::npos;
            if (level.empty() || item.mesh->triangles.empty() || (left && sight.x() > 0.5)
                || (right && sight.x() < -0.5))
                continue; // on the far side
            Eigen::Index nearest = 0;
            (item.mesh->vertices * sight).minCoeff(&nearest);
            words.push_back({ std::string(level), item.mesh->vertices.row(nearest).transpose(), { 1.0, 1.0, 1.0 } });
        }
        return words;
    }

    Scene side_scene(
        const std::vector<SurfaceItem>& surfaces, const Box& box, const Side& side, double width, double height)
    {
        Scene scene;
        scene.title = side.name;
        scene.font_px = kFont;
        scene.surfaces = surfaces;
        scene.words = level_words(surfaces, side.sight);
        const Vec3 extent = box.high - box.low;
        const double across = std::abs(side.sight.x()) > 0.5 ? extent.y() : extent.x();
        scene.camera.parallel = true;
        scene.camera.aim = 0.5 * (box.low + box.high);
        scene.camera.eye = scene.camera.aim - side.sight * (extent.norm() + 10.0);
        scene.camera.up = Vec3::UnitZ();
        constexpr double kRoom = 1.10;
        scene.camera.half_height_mm = kRoom * 0.5 * std::max(extent.z(), across * height / width);
        return scene;
    }

    // ---- the page --------------------------------------------------------------------------------------------------

    /// A rectangle in pixels from the upper left corner. It becomes a viewport once the height is known.
    struct Cell {
        double left, top, width, height;
        Scene scene;
    };

    void add_slices(
        std::vector<Cell>& cells, double& top, const Content& content, const ContactSheetOptions& options, double width)
    {
        const std::optional<Vec3> focus = focus_of(content, options);
        const double cell_width = std::floor(width / options.columns);
        for (const Plane& plane : kPlanes) {
            const Vec3 extent = content.shown.high - content.shown.low;
            const double height
                = std::round(cell_width * std::clamp(extent[plane.upward] / extent[plane.across], 0.4, 1.6));
            std::vector<double> at = positions(content.spread.low[plane.normal], content.spread.high[plane.normal],
                options.columns, focus ? std::optional((*focus)[plane.normal]) : std::nullopt);
            if (plane.plane == SlicePlane::axial)
                std::reverse(at.begin(), at.end()); // from the head down, as radiologists hang films
            for (int n = 0; n < options.columns; ++n) {
                Scene scene = slice_scene(content, options, plane, at[static_cast<std::size_t>(n)], cell_width, height);
                scene.scale_bar = n == 0;
                cells.push_back({ n * cell_width, top, cell_width - 2.0, height - 2.0, std::move(scene) });
            }
            top += height;
        }
    }

    void add_sides(std::vector<Cell>& cells, double& top, const Content& content, double width, const Job& job)
    {
        const std::vector<SurfaceItem> surfaces = label_surfaces(*content.labels, job);
        Scene all;
        all.surfaces = surfaces;
        const std::optional<Box> box = scene_bounds(all);
        if (!box)
            return;
        const std::array<Side, 4> sides { { { "from the front", Vec3::UnitY() },
            { "from the patient's left", -Vec3::UnitX() }, { "from the patient's right", Vec3::UnitX() },
            { "from the back", -Vec3::UnitY() } } };
        const double cell_width = std::floor(width / static_cast<double>(sides.size()));
        const double height = std::round(0.9 * cell_width);
        for (std::size_t n = 0; n < sides.size(); ++n) {
            Scene scene = side_scene(surfaces, *box, sides[n], cell_width, height);
            scene.scale_bar = n == 0;
            cells.push_back(
                { static_cast<double>(n) * cell_width, top, cell_width - 2.0, height - 2.0, std::move(scene) });
        }
        top += height;
    }

    Scene panel()
    {
        Scene scene;
        scene.font_px = kFont;
        scene.orientation_marker = scene.scale_bar = false;
        scene.background_low = scene.background_high = { 0.09, 0.11, 0.13 };
        return scene;
    }

    void add_text(std::vector<Cell>& cells, double& top, const ContactSheetOptions& options)
    {
        constexpr double kLettersPerPixel = 1.0 / (0.50 * kFont);
        const auto columns = static_cast<std::size_t>((options.width - 2.0 * kFont) * kLettersPerPixel);
        Scene scene = panel();
        for (const std::string& warning : options.warnings)
            for (const std::string& line : wrapped("Look: " + warning, columns))
                scene.notes.push_back(line);
        for (const std::string& note : options.notes)
            for (const std::string& line : wrapped(note, columns))
                scene.notes.push_back(line);
        if (scene.notes.empty())
            return;
        const double height = std::ceil(kLine * (static_cast<double>(scene.notes.size()) + 1.2));
        cells.push_back({ 0.0, top, static_cast<double>(options.width), height, std::move(scene) });
        top += height;
    }

} // namespace

Picture contact_sheet(std::shared_ptr<const mesh::Volume> ct, std::shared_ptr<const mesh::LabelVolume> labels,
    const ContactSheetOptions& options, const Job& job)
{
    if (options.columns < 1 || options.columns > 12)
        throw InputError("a contact sheet has 1 to 12 columns, got " + std::to_string(options.columns));
    if (options.width < 800 || options.width > 8000)
        throw InputError("a contact sheet is 800 to 8000 pixels wide, got " + std::to_string(options.width));
    const Content content = gather(std::move(ct), std::move(labels));
    const bool with_legend = !content.counts.empty();
    const double main_width = options.width - (with_legend ? kLegendWidth : 0.0);

    std::vector<Cell> cells;
    Scene header = panel();
    header.title = header_text(content, options);
    cells.push_back({ 0.0, 0.0, static_cast<double>(options.width), kHeader, std::move(header) });
    double top = kHeader;
    add_slices(cells, top, content, options, main_width);
    if (options.surfaces && with_legend)
        add_sides(cells, top, content, main_width, job);
    if (with_legend) {
        Scene legend = panel();
        legend.legend_share = 1.0;
        legend.legend = legend_of(content, options.rough, static_cast<std::size_t>((top - kHeader) / kLine) - 2);
        cells.push_back({ main_width, kHeader, kLegendWidth, top - kHeader, std::move(legend) });
    }
    add_text(cells, top, options);

    Picture picture;
    picture.width = options.width;
    picture.height = static_cast<int>(std::ceil(top));
    const double height = picture.height;
    for (Cell& cell : cells) {
        const double width = picture.width;
        picture.viewports.push_back({ .left = cell.left / width,
            .bottom = std::max(0.0, 1.0 - (cell.top + cell.height) / height),
            .right = std::min(1.0, (cell.left + cell.width) / width),
            .top = 1.0 - cell.top / height,
            .scene = std::move(cell.scene) });
    }
    return picture;
}

} // namespace retractor::ui
