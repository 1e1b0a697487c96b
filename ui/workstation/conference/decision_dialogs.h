#pragma once
// Asks which approach a team chooses and why, and the six questions about the planned field.

#include "planner/decision/decisions.h"

#include <QDialog>

#include <array>
#include <string>
#include <vector>

class QButtonGroup;
class QLabel;
class QLineEdit;
class QPlainTextEdit;
class QPushButton;

namespace retractor::ui {

/// A choice: by whom and why.
class ChoiceDialog : public QDialog {
public:
    /// @param approach its name for people
    /// @param plan what the plan says, in its own sentences; empty: it is not planned
    /// @param holding the sentence of the choice so far; empty: there is none
    ChoiceDialog(const std::string& approach, const std::string& plan, const std::string& holding,
        const std::string& by, QWidget* parent);

    std::string by() const;
    std::string why() const;

private:
    QLineEdit* by_ = nullptr;
    QPlainTextEdit* why_ = nullptr;
    QPushButton* accept_ = nullptr;
};

/// The answers of one person, 1 to 5 points a question.
class AnswersDialog : public QDialog {
public:
    AnswersDialog(const std::string& by, QWidget* parent);

    /// @pre the dialog was accepted
    planner::Answers answers() const;

private:
    void show_whether_complete();

    QLineEdit *by_ = nullptr, *note_ = nullptr;
    std::array<QButtonGroup*, planner::kQuestions.size()> points_ {};
    QPushButton* accept_ = nullptr;
};

/// What the answers to several cases come to: for each question their number, mean, range and how often 1 to 5 points
/// were given.
class SummaryDialog : public QDialog {
public:
    /// @param cases the answers of each case; @param remarks cases without answers, and those that cannot be read
    SummaryDialog(const std::vector<std::vector<planner::Answers>>& cases, const QString& remarks, QWidget* parent);
};

/// The means of all answers to a case, in words; empty: there are none.
std::string answers_text(const planner::Decisions& decisions);

} // namespace retractor::ui
