#include "ui/workstation/language/language.h"

#include "mesh/base/error.h"
#include "ui/scene/vtk/annotations.h"
#include "ui/workstation/language/phrasebook.h"

#include <QAbstractButton>
#include <QAction>
#include <QComboBox>
#include <QCommandLinkButton>
#include <QDoubleSpinBox>
#include <QFile>
#include <QFontDatabase>
#include <QGroupBox>
#include <QLabel>
#include <QLineEdit>
#include <QLocale>
#include <QMenu>
#include <QPlainTextEdit>
#include <QSettings>
#include <QSpinBox>
#include <QTabWidget>
#include <QTableWidget>
#include <QToolButton>

#include <algorithm>

// Qt wants this outside of namespaces.
static void init_translations() { Q_INIT_RESOURCE(translations); }

namespace retractor::ui {

namespace {

    constexpr const char* kSetting = "language";
    /// Where systems have a font with Japanese letters, for the texts in pictures; the first is Debian's
    /// fonts-noto-cjk.
    constexpr std::array kJapaneseFonts { "/usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc",
        "/usr/share/fonts/google-noto-cjk/NotoSansCJK-Regular.ttc",
        "/usr/share/fonts/opentype/ipafont-gothic/ipag.ttf" };

    struct Chosen {
        QString code = "en";
        Phrasebook book; ///< empty in English
        QHash<QString, QString> said; ///< texts that were asked for lately: many are asked for at every picture
        bool in_pictures = false; ///< there is a font for them
    };

    /// Used on the interface's thread only.
    Chosen& chosen()
    {
        static Chosen language;
        return language;
    }

    QSettings settings() { return QSettings("Retractor", "retractor-workstation"); }

    /// Empty: none.
    std::string picture_font(const QString& code)
    {
        if (code == "ja")
            for (const char* const file : kJapaneseFonts)
                if (QFile::exists(file))
                    return file;
        return {};
    }

    bool is_known(const QString& code)
    {
        return std::ranges::any_of(kLanguages, [&](const Language& language) { return code == language.code; });
    }

    /// Gives a text anew where it has a translation.
    template <class Get, class Set> void translate(const Get& get, const Set& set)
    {
        const QString now = get(), then = translated(now);
        if (then != now)
            set(then);
    }

    template <class Box> void translate_spin_box(Box& box)
    {
        translate([&] { return box.prefix(); }, [&](const QString& text) { box.setPrefix(text); });
        translate([&] { return box.suffix(); }, [&](const QString& text) { box.setSuffix(text); });
        translate([&] { return box.specialValueText(); }, [&](const QString& text) { box.setSpecialValueText(text); });
    }

    void translate_choices(QComboBox& box)
    {
        if (box.isEditable())
            return; // its text is what the program reads
        for (int i = 0; i < box.count(); ++i) {
            translate([&] { return box.itemText(i); }, [&](const QString& text) { box.setItemText(i, text); });
            translate([&] { return box.itemData(i, Qt::ToolTipRole).toString(); },
                [&](const QString& text) { box.setItemData(i, text, Qt::ToolTipRole); });
        }
    }

    void translate_headers(QTableWidget& table)
    {
        for (int i = 0; i < table.columnCount(); ++i)
            if (QTableWidgetItem* item = table.horizontalHeaderItem(i))
                translate([&] { return item->text(); }, [&](const QString& text) { item->setText(text); });
    }

    void translate_button(QAbstractButton& button)
    {
        const auto* const tool = qobject_cast<const QToolButton*>(&button);
        if (tool != nullptr && tool->defaultAction() != nullptr)
            return; // it has its action's text
        translate([&] { return button.text(); }, [&](const QString& text) { button.setText(text); });
        if (auto* const link = qobject_cast<QCommandLinkButton*>(&button))
            translate([&] { return link->description(); }, [&](const QString& text) { link->setDescription(text); });
    }

    void translate_widget(QWidget& widget)
    {
        translate([&] { return widget.windowTitle(); }, [&](const QString& text) { widget.setWindowTitle(text); });
        translate([&] { return widget.toolTip(); }, [&](const QString& text) { widget.setToolTip(text); });
        translate(
            [&] { return widget.accessibleName(); }, [&](const QString& text) { widget.setAccessibleName(text); });
        if (auto* const label = qobject_cast<QLabel*>(&widget))
            translate([&] { return label->text(); }, [&](const QString& text) { label->setText(text); });
        else if (auto* const button = qobject_cast<QAbstractButton*>(&widget))
            translate_button(*button);
        else if (auto* const box = qobject_cast<QComboBox*>(&widget))
            translate_choices(*box);
        else if (auto* const whole = qobject_cast<QSpinBox*>(&widget))
            translate_spin_box(*whole);
        else if (auto* const number = qobject_cast<QDoubleSpinBox*>(&widget))
            translate_spin_box(*number);
        else if (auto* const line = qobject_cast<QLineEdit*>(&widget))
            translate(
                [&] { return line->placeholderText(); }, [&](const QString& text) { line->setPlaceholderText(text); });
        else if (auto* const note = qobject_cast<QPlainTextEdit*>(&widget))
            translate(
                [&] { return note->placeholderText(); }, [&](const QString& text) { note->setPlaceholderText(text); });
        else if (auto* const menu = qobject_cast<QMenu*>(&widget))
            translate([&] { return menu->title(); }, [&](const QString& text) { menu->setTitle(text); });
        else if (auto* const group = qobject_cast<QGroupBox*>(&widget))
            translate([&] { return group->title(); }, [&](const QString& text) { group->setTitle(text); });
        else if (auto* const tabs = qobject_cast<QTabWidget*>(&widget))
            for (int i = 0; i < tabs->count(); ++i)
                translate([&] { return tabs->tabText(i); }, [&](const QString& text) { tabs->setTabText(i, text); });
        else if (auto* const table = qobject_cast<QTableWidget*>(&widget))
            translate_headers(*table);
    }

} // namespace

void set_language(const QString& code)
{
    if (!is_known(code))
        throw InputError("the window does not speak \"" + code.toStdString() + "\": en or ja", "language");
    Phrasebook book;
    if (code != "en") {
        init_translations();
        QFile file(":/language/" + code + ".ts");
        if (!file.open(QIODevice::ReadOnly))
            throw InputError("the translation is not in the program", code.toStdString());
        book = read_phrasebook(file);
    }
    const std::string font = picture_font(code);
    set_annotation_font(font);
    chosen() = { .code = code, .book = std::move(book), .said = {}, .in_pictures = !font.empty() };
}

const Phrasebook* language_book() { return chosen().code == "en" ? nullptr : &chosen().book; }

QString language() { return chosen().code; }

QString preferred_language()
{
    if (const QString kept = settings().value(kSetting).toString(); is_known(kept))
        return kept;
    const bool japanese = QLocale::system().language() == QLocale::Japanese
        && !QFontDatabase().families(QFontDatabase::Japanese).isEmpty();
    return japanese ? "ja" : "en";
}

void prefer_language(const QString& code) { settings().setValue(kSetting, code); }

QString translated(const QString& english)
{
    constexpr int kMostSaid = 2000;
    if (chosen().code == "en" || english.isEmpty())
        return english;
    QHash<QString, QString>& said = chosen().said;
    if (const auto found = said.constFind(english); found != said.constEnd())
        return *found;
    if (said.size() >= kMostSaid)
        said.clear();
    return *said.insert(english, translated(chosen().book, english));
}

QString translated(const std::string& english) { return translated(QString::fromStdString(english)); }

QString translated(const char* english) { return translated(QString::fromUtf8(english)); }

TextLanguage picture_language()
{
    if (!chosen().in_pictures)
        return {};
    return [book = language_book()](
               const std::string& english) { return translated(*book, QString::fromStdString(english)).toStdString(); };
}

void translate_texts(Scene& scene)
{
    if (!chosen().in_pictures)
        return;
    say_texts(scene, [](const std::string& text) { return translated(text).toStdString(); });
}

void translate_texts(QWidget& window)
{
    if (chosen().code == "en")
        return;
    translate_widget(window);
    for (QWidget* const widget : window.findChildren<QWidget*>())
        translate_widget(*widget);
    for (QAction* const action : window.findChildren<QAction*>()) {
        translate([&] { return action->text(); }, [&](const QString& text) { action->setText(text); });
        translate([&] { return action->toolTip(); }, [&](const QString& text) { action->setToolTip(text); });
    }
}

} // namespace retractor::ui
