#pragma once
// The panel on the right while labels are corrected: what the brush does, and the list of labels.

#include "mesh/image/volume.h"
#include "ui/workstation/labels/label_tool.h"

#include <QWidget>

#include <functional>
#include <string>
#include <vector>

class QButtonGroup;
class QCheckBox;
class QLabel;
class QListWidget;
class QPushButton;
class QSlider;

namespace retractor::ui {

class LabelPanel : public QWidget {
public:
    explicit LabelPanel(QWidget* parent = nullptr);

    /// @param session null: the labels are not read yet, for the reason `waiting` says
    void show_session(const planner::LabelSession* session, const QString& waiting);
    LabelBrushState state() const;
    /// Name of the chosen label; empty: none.
    std::string chosen() const;
    void choose(const std::string& name);
    /// No label stays chosen for the next list: it is another case's.
    void forget_choice() { last_id_ = 0; }

    /// What the buttons under the list do with the chosen label.
    enum class Action { smooth, largest, between, join, rename, confirm, add, save, discard };

    // Set by the owner.
    std::function<void()> on_state; ///< state() is another one
    std::function<void(Action)> on_action;
    std::function<void()> on_click; ///< a label was clicked in the list: show where it lies

    QListWidget& list() { return *list_; }
    QSlider& size() { return *size_; }
    QPushButton& button(Action action);

private:
    QPushButton* add_button(Action action, const QString& text, const QString& tip);
    void show_size();

    QButtonGroup* brushes_ = nullptr;
    QSlider* size_ = nullptr;
    QLabel *size_text_ = nullptr, *note_ = nullptr;
    QCheckBox *ball_ = nullptr, *keeps_bone_ = nullptr;
    QListWidget* list_ = nullptr;
    QButtonGroup* actions_ = nullptr;
    bool showing_ = false; ///< the list is being filled
    /// A line of the list.
    struct Row {
        Label id = 0;
        std::string name;
        bool estimated = false;
        bool operator==(const Row&) const = default;
    };
    std::vector<Row> rows_;

    int last_id_ = 0; ///< of the label that is chosen, also while the list is empty

    void fill_list();
    static QString words_of(const Row& row, double volume_ml);
};

} // namespace retractor::ui
