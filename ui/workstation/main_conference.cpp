// The conference of the main window: full screen, large type, the plans step by step.

#include "ui/workstation/conference/conference_bar.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/view/picture_view.h"

#include <QActionGroup>
#include <QMenuBar>
#include <QPainter>
#include <QStatusBar>
#include <QTabWidget>
#include <QToolBar>

#include <algorithm>
#include <utility>

namespace retractor::ui {

namespace {

    /// A red disc that everybody in the room sees.
    QCursor pointer()
    {
        constexpr int kAcrossPx = 18;
        QPixmap picture(kAcrossPx, kAcrossPx);
        picture.fill(Qt::transparent);
        QPainter painter(&picture);
        painter.setRenderHint(QPainter::Antialiasing);
        painter.setPen(QPen(Qt::white, 1.0));
        painter.setBrush(QColor(255, 40, 40));
        painter.drawEllipse(1, 1, kAcrossPx - 2, kAcrossPx - 2);
        painter.end();
        return QCursor(picture, kAcrossPx / 2, kAcrossPx / 2);
    }

} // namespace

void MainWindow::make_conference()
{
    conference_bar_->on_step = [this](int steps) { step_by(steps); };
    conference_bar_->on_end = [this] { set_conference(false); };
    presenter_keys_ = new QActionGroup(this);
    const auto add_keys = [this](const QList<QKeySequence>& keys, std::function<void()> run) {
        auto* action = new QAction(this);
        action->setShortcuts(keys);
        connect(action, &QAction::triggered, this, [run = std::move(run)] { run(); });
        presenter_keys_->addAction(action);
        addAction(action);
    };
    // Presenters for slides send these keys.
    add_keys({ Qt::Key_Right, Qt::Key_PageDown, Qt::Key_Space }, [this] { step_by(1); });
    add_keys({ Qt::Key_Left, Qt::Key_PageUp, Qt::Key_Backspace }, [this] { step_by(-1); });
    add_keys({ Qt::Key_Home }, [this] { go_to_step(0); });
    add_keys({ Qt::Key_End }, [this] { go_to_step(steps_.size() - 1); });
    presenter_keys_->setEnabled(false);
}

void MainWindow::show_frame(bool shown)
{
    menuBar()->setVisible(shown);
    tool_bar_->setVisible(shown);
    statusBar()->setVisible(shown);
    approach_pane_->setVisible(shown);
    tabs_->setVisible(shown);
    conference_bar_->setVisible(!shown);
}

void MainWindow::set_conference(bool on)
{
    if (on == in_conference() || (on && !model_))
        return;
    if (on) {
        set_measuring(false);
        editor_->abandon();
        tabs_->setCurrentIndex(0);
        set_knife(KnifeMode::away);
        steps_ = presentation_of(*model_);
        was_maximized_ = isMaximized();
        showFullScreen();
        view_->setCursor(pointer());
    } else {
        steps_.clear();
        was_maximized_ ? showMaximized() : showNormal();
        view_->unsetCursor();
    }
    show_frame(!on);
    presenter_keys_->setEnabled(on);
    if (!on)
        return show_all();
    const auto begins = std::find_if(steps_.begin(), steps_.end(),
        [&](const PresentationStep& step) { return step.approach == model_->selected(); });
    go_to_step(begins == steps_.end() ? 0 : static_cast<std::size_t>(begins - steps_.begin()));
}

void MainWindow::step_by(int steps)
{
    const auto last = static_cast<int>(steps_.size()) - 1;
    go_to_step(static_cast<std::size_t>(std::clamp(static_cast<int>(step_) + steps, 0, last)));
}

void MainWindow::go_to_step(std::size_t number)
{
    if (!in_conference() || number >= steps_.size())
        return;
    step_ = number;
    const PresentationStep& step = steps_[number];
    if (step.approach && model_->selected() != step.approach)
        model_->select(*step.approach);
    model_->set_view(step.view);
    model_->set_alone(std::nullopt);
    model_->set_show_opened(step.opened);
    conference_bar_->show_step(step, number + 1, steps_.size());
    hand_out_work();
    show_all();
}

} // namespace retractor::ui
