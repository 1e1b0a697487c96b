<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="ja_JP" sourcelanguage="en">
<context>
    <name>Retractor</name>
    <message>
        <source>&amp;File</source>
        <translation>ファイル(&amp;F)</translation>
    </message>
    <message>
        <source>&amp;View</source>
        <translation>表示(&amp;V)</translation>
    </message>
    <message>
        <source>&amp;Approach</source>
        <translation>アプローチ(&amp;A)</translation>
    </message>
    <message>
        <source>&amp;Knife</source>
        <translation>メス(&amp;K)</translation>
    </message>
    <message>
        <source>&amp;Help</source>
        <translation>ヘルプ(&amp;H)</translation>
    </message>
    <message>
        <source>Manual</source>
        <translation>マニュアル</translation>
    </message>
    <message>
        <source>Open the manual at what is shown</source>
        <translation>今の画面についてのマニュアルを開く</translation>
    </message>
    <message>
        <source>Tour</source>
        <translation>ツアー</translation>
    </message>
    <message>
        <source>See in eight steps what this window does</source>
        <translation>このウィンドウでできることを八つの場面で見る</translation>
    </message>
    <message>
        <source>Save the log…</source>
        <translation>ログを保存…</translation>
    </message>
    <message>
        <source>What the window said, to be attached to a report of a fault</source>
        <translation>不具合の報告に添えるため、ウィンドウに出た表示を保存する</translation>
    </message>
    <message>
        <source>About Retractor</source>
        <translation>Retractor について</translation>
    </message>
    <message>
        <source>Show the version and the licence</source>
        <translation>版とライセンスを表示する</translation>
    </message>
    <message>
        <source>Language</source>
        <translation>言語 (Language)</translation>
    </message>
    <message>
        <source>The language of the window, from the next start on</source>
        <translation>ウィンドウの言語。次に起動したときから変わる</translation>
    </message>
    <message>
        <source>The window speaks %1 from its next start on.</source>
        <translation>次に起動したときから、ウィンドウの言語は%1になります。</translation>
    </message>
    <message>
        <source>Import a study…</source>
        <translation>検査を取り込む…</translation>
    </message>
    <message>
        <source>Make a case from a CT</source>
        <translation>CT から症例を作る</translation>
    </message>
    <message>
        <source>Open case…</source>
        <translation>症例を開く…</translation>
    </message>
    <message>
        <source>Open a case.json</source>
        <translation>case.json を開く</translation>
    </message>
    <message>
        <source>Close case</source>
        <translation>症例を閉じる</translation>
    </message>
    <message>
        <source>Go back to the start page</source>
        <translation>開始画面に戻る</translation>
    </message>
    <message>
        <source>Save picture…</source>
        <translation>画像を保存…</translation>
    </message>
    <message>
        <source>Save the picture as PNG</source>
        <translation>画像を PNG で保存する</translation>
    </message>
    <message>
        <source>Save a movie…</source>
        <translation>動画を保存…</translation>
    </message>
    <message>
        <source>Save a movie of the plans: cut, opened, seen through the incision, and reached</source>
        <translation>計画の動画を保存する：切開、開創、切開部からの視野、手の届く所</translation>
    </message>
    <message>
        <source>Save the report…</source>
        <translation>報告書を保存…</translation>
    </message>
    <message>
        <source>Save the plans with numbers and pictures as a page for the browser</source>
        <translation>計画を数値と画像つきでブラウザ用のページに保存する</translation>
    </message>
    <message>
        <source>Palpate a structure…</source>
        <translation>触診する…</translation>
    </message>
    <message>
        <source>Palpate a vessel or an organ of this case in a new window</source>
        <translation>この症例の血管や臓器を新しいウィンドウで触診する</translation>
    </message>
    <message>
        <source>Quit</source>
        <translation>終了</translation>
    </message>
    <message>
        <source>Close the window</source>
        <translation>ウィンドウを閉じる</translation>
    </message>
    <message>
        <source>Surgeon's eye</source>
        <translation>術者の目</translation>
    </message>
    <message>
        <source>View through the incision</source>
        <translation>切開部からの眺め</translation>
    </message>
    <message>
        <source>Overview</source>
        <translation>全体</translation>
    </message>
    <message>
        <source>View of the patient from outside</source>
        <translation>患者を外から見る</translation>
    </message>
    <message>
        <source>Slices</source>
        <translation>断面</translation>
    </message>
    <message>
        <source>Three planes of the CT and the overview</source>
        <translation>CT の三断面と全体</translation>
    </message>
    <message>
        <source>Incision</source>
        <translation>切開</translation>
    </message>
    <message>
        <source>Slices along and across the incision, with the cut</source>
        <translation>切開に沿う断面と直交する断面に、切り口を重ねる</translation>
    </message>
    <message>
        <source>Compare</source>
        <translation>比較</translation>
    </message>
    <message>
        <source>Two to four planned approaches beside each other, with their numbers</source>
        <translation>計画した 2～4 のアプローチを数値とともに並べる</translation>
    </message>
    <message>
        <source>Mediastinum</source>
        <translation>縦隔</translation>
    </message>
    <message>
        <source>Lung</source>
        <translation>肺</translation>
    </message>
    <message>
        <source>Bone</source>
        <translation>骨</translation>
    </message>
    <message>
        <source>Angiography</source>
        <translation>血管造影</translation>
    </message>
    <message>
        <source>Slices from %1 to %2 HU</source>
        <translation>断面の濃淡 %1 〜 %2 HU</translation>
    </message>
    <message>
        <source>Labels filled</source>
        <translation>ラベルを塗る</translation>
    </message>
    <message>
        <source>Slices with labels in their colours</source>
        <translation>断面のラベルをその色で塗る</translation>
    </message>
    <message>
        <source>Labels outlined</source>
        <translation>ラベルを輪郭で</translation>
    </message>
    <message>
        <source>Slices with the outlines of the labels</source>
        <translation>断面にラベルの輪郭を描く</translation>
    </message>
    <message>
        <source>No labels</source>
        <translation>ラベルなし</translation>
    </message>
    <message>
        <source>Slices of the CT alone</source>
        <translation>CT だけの断面</translation>
    </message>
    <message>
        <source>Colours of the opened field</source>
        <translation>開いた術野の色</translation>
    </message>
    <message>
        <source>Colours: %1</source>
        <translation>色：%1</translation>
    </message>
    <message>
        <source>Tissues</source>
        <translation>組織</translation>
    </message>
    <message>
        <source>Strain</source>
        <translation>ひずみ</translation>
    </message>
    <message>
        <source>Pressure of the blades</source>
        <translation>ブレードの圧力</translation>
    </message>
    <message>
        <source>Distance to structures at risk</source>
        <translation>損傷してはならない構造までの距離</translation>
    </message>
    <message>
        <source>How much of the view shows each part of the target</source>
        <translation>標的の各部がどれだけの視点から見えるか</translation>
    </message>
    <message>
        <source>Where the eye sees how much</source>
        <translation>どの視点からどれだけ見えるか</translation>
    </message>
    <message>
        <source>What a finger and two instruments reach</source>
        <translation>指と二本の器械が届く所</translation>
    </message>
    <message>
        <source>Opened</source>
        <translation>開創後</translation>
    </message>
    <message>
        <source>Switch between the opened field and the patient before the cut</source>
        <translation>開いた術野と切開前の患者を切り替える</translation>
    </message>
    <message>
        <source>Turn together</source>
        <translation>一緒に回す</translation>
    </message>
    <message>
        <source>In the comparison, all pictures turn and zoom with the one under the mouse</source>
        <translation>比較では、マウスの下の画像に合わせてすべての画像が回り、拡大縮小する</translation>
    </message>
    <message>
        <source>The pictures turn together</source>
        <translation>画像は一緒に回ります</translation>
    </message>
    <message>
        <source>Each picture turns alone</source>
        <translation>画像は一つずつ回ります</translation>
    </message>
    <message>
        <source>Reset the view</source>
        <translation>眺めを戻す</translation>
    </message>
    <message>
        <source>Show the picture again from where it was seen first</source>
        <translation>最初の位置からの眺めに戻す</translation>
    </message>
    <message>
        <source>Keep this view…</source>
        <translation>この眺めを残す…</translation>
    </message>
    <message>
        <source>Keep the view as a step of the conference and of movies</source>
        <translation>眺めをカンファレンスと動画の一場面として残す</translation>
    </message>
    <message>
        <source>Forget a kept view…</source>
        <translation>残した眺めを消す…</translation>
    </message>
    <message>
        <source>Remove a view that was kept</source>
        <translation>残しておいた眺めを消す</translation>
    </message>
    <message>
        <source>Measure</source>
        <translation>計測</translation>
    </message>
    <message>
        <source>Measure distances and angles on slices or on the skin</source>
        <translation>断面または皮膚の上で距離と角度を測る</translation>
    </message>
    <message>
        <source>Remove the measurements</source>
        <translation>計測を消去</translation>
    </message>
    <message>
        <source>Remove all distances, angles and areas</source>
        <translation>距離、角度、面積をすべて消す</translation>
    </message>
    <message>
        <source>The palpation was cancelled.</source>
        <translation>触診を取り消しました。</translation>
    </message>
    <message>
        <source>Measure an area</source>
        <translation>面積を計測</translation>
    </message>
    <message>
        <source>Measure an area on slices or on the skin: click its corners</source>
        <translation>断面または皮膚の上で面積を測る：角をクリックする</translation>
    </message>
    <message>
        <source>Correct labels</source>
        <translation>ラベルを直す</translation>
    </message>
    <message>
        <source>Paint, erase and rename labels on the slices</source>
        <translation>断面の上でラベルを塗り、消し、名前を変える</translation>
    </message>
    <message>
        <source>Conference</source>
        <translation>カンファレンス</translation>
    </message>
    <message>
        <source>Full screen, large type: the plans step by step</source>
        <translation>全画面、大きな文字で、計画を一場面ずつ示す</translation>
    </message>
    <message>
        <source>Notes</source>
        <translation>メモ</translation>
    </message>
    <message>
        <source>In the conference: the presenter's notes, on a second screen where there is one</source>
        <translation>カンファレンス中の発表者のメモ。二つめの画面があればそこに出す</translation>
    </message>
    <message>
        <source>New…</source>
        <translation>新規…</translation>
    </message>
    <message>
        <source>Add a standard approach</source>
        <translation>標準的なアプローチを加える</translation>
    </message>
    <message>
        <source>Draw</source>
        <translation>描く</translation>
    </message>
    <message>
        <source>Draw an incision on the skin: click its points, or drag along it</source>
        <translation>皮膚に切開を描く：点をクリックするか、なぞる</translation>
    </message>
    <message>
        <source>Move</source>
        <translation>動かす</translation>
    </message>
    <message>
        <source>Drag the points of the incision</source>
        <translation>切開の点をドラッグする</translation>
    </message>
    <message>
        <source>Finish the incision</source>
        <translation>切開を確定</translation>
    </message>
    <message>
        <source>End drawing or moving</source>
        <translation>描画または移動を終える</translation>
    </message>
    <message>
        <source>Target and opening…</source>
        <translation>標的と開創…</translation>
    </message>
    <message>
        <source>Change…</source>
        <translation>変更…</translation>
    </message>
    <message>
        <source>Change the target, the retractor or the name</source>
        <translation>標的、開創器、名前を変える</translation>
    </message>
    <message>
        <source>Target here…</source>
        <translation>ここを標的に…</translation>
    </message>
    <message>
        <source>Make the marked place, where the slices meet, the target: an anastomosis, a clamp, a neck, an annulus</source>
        <translation>断面が交わる印の位置を標的にする：吻合部、遮断部、瘤のネック、弁輪</translation>
    </message>
    <message>
        <source>Duplicate</source>
        <translation>複製</translation>
    </message>
    <message>
        <source>Add a copy</source>
        <translation>複製を加える</translation>
    </message>
    <message>
        <source>Add neighbours</source>
        <translation>隣を加える</translation>
    </message>
    <message>
        <source>Add the same approach one space higher and lower, and 20 mm along</source>
        <translation>一つ上と下の肋間、および 20 mm ずらした同じアプローチを加える</translation>
    </message>
    <message>
        <source>Search…</source>
        <translation>探索…</translation>
    </message>
    <message>
        <source>Search for an incision that shows the target: which space, where, how long, or through the sternum</source>
        <translation>標的が見える切開を探す：どの肋間か、どこを、どの長さで、または胸骨を通るか</translation>
    </message>
    <message>
        <source>Remove</source>
        <translation>削除</translation>
    </message>
    <message>
        <source>Remove this approach</source>
        <translation>このアプローチを消す</translation>
    </message>
    <message>
        <source>Weights…</source>
        <translation>重み…</translation>
    </message>
    <message>
        <source>How much each criterion counts in the score of the comparison</source>
        <translation>比較の点数で各項目をどれだけ重く見るか</translation>
    </message>
    <message>
        <source>Choose…</source>
        <translation>決定…</translation>
    </message>
    <message>
        <source>Record that the team chooses this approach, and why</source>
        <translation>チームがこのアプローチを選んだことと、その理由を記録する</translation>
    </message>
    <message>
        <source>Six questions…</source>
        <translation>六つの質問…</translation>
    </message>
    <message>
        <source>Answer the questions about the planned field</source>
        <translation>計画した術野についての質問に答える</translation>
    </message>
    <message>
        <source>Answers over cases…</source>
        <translation>症例全体の回答…</translation>
    </message>
    <message>
        <source>Sum up the answers to the six questions over several cases</source>
        <translation>六つの質問への回答を複数の症例にわたってまとめる</translation>
    </message>
    <message>
        <source>Plan</source>
        <translation>計画</translation>
    </message>
    <message>
        <source>Cut, open and measure this approach</source>
        <translation>このアプローチで切り、開き、測る</translation>
    </message>
    <message>
        <source>Plan all</source>
        <translation>すべて計画</translation>
    </message>
    <message>
        <source>Plan a draft</source>
        <translation>ドラフトを計画</translation>
    </message>
    <message>
        <source>Cut, open and measure this approach quickly, on a coarse model and without errors; a draft is not saved</source>
        <translation>このアプローチを粗いモデルで手早く切開・展開・計測します（誤差なし）；ドラフトは保存されません</translation>
    </message>
    <message>
        <source>Draft: %1</source>
        <translation>ドラフト：%1</translation>
    </message>
    <message>
        <source>This is a draft: its force, and with it what breaks, may be half of the plan's or more than twice. It is not saved. P makes the plan.</source>
        <translation>これはドラフトです：力と、それによる骨折の予測は、計画の半分から 2 倍以上まで違うことがあります。保存されません。P で計画します。</translation>
    </message>
    <message>
        <source>Cut, open and measure all approaches</source>
        <translation>すべてのアプローチで切り、開き、測る</translation>
    </message>
    <message>
        <source>Cancel</source>
        <translation>中止</translation>
    </message>
    <message>
        <source>Discard the open stroke or incision, end measuring, or stop what is being computed</source>
        <translation>描きかけの線や切開を捨てる、または計画を止める</translation>
    </message>
    <message>
        <source>Knife</source>
        <translation>メス</translation>
    </message>
    <message>
        <source>Draw cuts on the skin with the left button</source>
        <translation>左ボタンで皮膚の上に切開を描く</translation>
    </message>
    <message>
        <source>Line</source>
        <translation>直線</translation>
    </message>
    <message>
        <source>Cut straight between two clicks</source>
        <translation>二つのクリックの間をまっすぐ切る</translation>
    </message>
    <message>
        <source>Hooks</source>
        <translation>鉤</translation>
    </message>
    <message>
        <source>Press on the edge of a wound to set a hook; drag a hook to pull it</source>
        <translation>創縁を押して鉤をかける。鉤をドラッグして引く</translation>
    </message>
    <message>
        <source>Take out</source>
        <translation>取り除く</translation>
    </message>
    <message>
        <source>Press on a loose piece or on tissue to remove it</source>
        <translation>離れた片や組織を押して取り除く</translation>
    </message>
    <message>
        <source>Undo</source>
        <translation>元に戻す</translation>
    </message>
    <message>
        <source>Take the last step back</source>
        <translation>直前の操作を取り消す</translation>
    </message>
    <message>
        <source>Redo</source>
        <translation>やり直す</translation>
    </message>
    <message>
        <source>Make the step again</source>
        <translation>取り消した操作をもう一度行う</translation>
    </message>
    <message>
        <source>Tools</source>
        <translation>道具</translation>
    </message>
    <message>
        <source>Body wall</source>
        <translation>体壁</translation>
    </message>
    <message>
        <source>Solid</source>
        <translation>不透明</translation>
    </message>
    <message>
        <source>Skin, muscle and ribs as they are</source>
        <translation>皮膚、筋、肋骨をそのまま見せる</translation>
    </message>
    <message>
        <source>See-through</source>
        <translation>半透明</translation>
    </message>
    <message>
        <source>Bones, heart and vessels shine through the skin</source>
        <translation>骨、心臓、血管が皮膚を透かして見える</translation>
    </message>
    <message>
        <source>Hidden</source>
        <translation>隠す</translation>
    </message>
    <message>
        <source>Bones, heart and vessels alone</source>
        <translation>骨、心臓、血管だけを見せる</translation>
    </message>
    <message>
        <source>Next</source>
        <translation>次へ</translation>
    </message>
    <message>
        <source>Solid, see-through, hidden</source>
        <translation>不透明、半透明、隠す</translation>
    </message>
    <message>
        <source>Cut away</source>
        <translation>切り取り</translation>
    </message>
    <message>
        <source>Cut this part away, up to where the slices meet; Shift and the wheel move the cut</source>
        <translation>断面が交わる所までを切り取って見る。Shift とホイールで切り口が動く</translation>
    </message>
    <message>
        <source>Show the whole patient</source>
        <translation>患者全体を見せる</translation>
    </message>
    <message>
        <source>Nothing</source>
        <translation>なし</translation>
    </message>
    <message>
        <source>The front</source>
        <translation>前</translation>
    </message>
    <message>
        <source>The back</source>
        <translation>後ろ</translation>
    </message>
    <message>
        <source>The patient's left</source>
        <translation>患者の左</translation>
    </message>
    <message>
        <source>The patient's right</source>
        <translation>患者の右</translation>
    </message>
    <message>
        <source>Towards the head</source>
        <translation>頭側</translation>
    </message>
    <message>
        <source>Towards the feet</source>
        <translation>足側</translation>
    </message>
    <message>
        <source>Nothing, the front, the back, one side after the other</source>
        <translation>なし、前、後ろ、と順に変える</translation>
    </message>
    <message>
        <source>Endoscope, straight</source>
        <translation>内視鏡（直視）</translation>
    </message>
    <message>
        <source>Look into the opened wound through an endoscope, 50 mm before the target</source>
        <translation>標的の 50 mm 手前に置いた内視鏡で開いた創をのぞく</translation>
    </message>
    <message>
        <source>Endoscope, 30°</source>
        <translation>内視鏡（30°）</translation>
    </message>
    <message>
        <source>The same with optics that look 30° off the shaft; again: turned by 90° about the shaft</source>
        <translation>シャフトから 30° 傾いた斜視鏡。もう一度押すと軸のまわりに 90° 回る</translation>
    </message>
    <message>
        <source>One large picture</source>
        <translation>大きな画像を一つ</translation>
    </message>
    <message>
        <source>With slices, the picture in space fills two thirds of the view</source>
        <translation>断面とともに表示するとき、立体の画像が画面の三分の二を占める</translation>
    </message>
    <message>
        <source>The body's wall is see-through.</source>
        <translation>体壁を半透明にしました。</translation>
    </message>
    <message>
        <source>The body's wall is solid.</source>
        <translation>体壁を不透明にしました。</translation>
    </message>
    <message>
        <source>The body's wall is hidden.</source>
        <translation>体壁を隠しました。</translation>
    </message>
    <message>
        <source>Shift and the wheel move the cut.</source>
        <translation>Shift とホイールで切り口が動きます。</translation>
    </message>
    <message>
        <source>Endoscope, 30° off its shaft, 50 mm before the target; 7 turns it, 0 goes back to the surgeon's eye.</source>
        <translation>30° 斜視の内視鏡、標的の 50 mm 手前。7 で回り、0 で術者の目に戻ります。</translation>
    </message>
    <message>
        <source>Endoscope, straight, 50 mm before the target; 0 goes back to the surgeon's eye.</source>
        <translation>直視の内視鏡、標的の 50 mm 手前。0 で術者の目に戻ります。</translation>
    </message>
    <message>
        <source>%1. T makes this place the target; 3 shows its slices.</source>
        <translation>%1。T でここを標的にし、3 でその断面を見ます。</translation>
    </message>
    <message>
        <source>Close</source>
        <translation>閉じる</translation>
    </message>
    <message>
        <source>Not a medical device</source>
        <translation>医療機器ではありません</translation>
    </message>
    <message>
        <source>A plan is being calculated. If you close now, the plan ends and its result is lost.</source>
        <translation>計画を計算しています。今閉じると計算は終わり、結果は失われます。</translation>
    </message>
    <message>
        <source>Go on planning</source>
        <translation>計画を続ける</translation>
    </message>
    <message>
        <source>The corrected labels are not saved. If you close now, the corrections are lost.</source>
        <translation>直したラベルは保存されていません。今閉じると修正は失われます。</translation>
    </message>
    <message>
        <source>Go back</source>
        <translation>戻る</translation>
    </message>
    <message>
        <source>A search for an incision is running. If you close now, its result is lost.</source>
        <translation>切開を探しています。今閉じると結果は失われます。</translation>
    </message>
    <message>
        <source>Go on searching</source>
        <translation>探索を続ける</translation>
    </message>
    <message>
        <source>The approaches of this case are not saved. If you close now, they are lost. %1</source>
        <translation>この症例のアプローチは保存されていません。今閉じると失われます。%1</translation>
    </message>
    <message>
        <source>Close the window?</source>
        <translation>ウィンドウを閉じますか</translation>
    </message>
    <message>
        <source>A file is being saved. If you close now, it is not saved.</source>
        <translation>ファイルを保存しています。今閉じると保存されません。</translation>
    </message>
    <message>
        <source>Go on saving</source>
        <translation>保存を続ける</translation>
    </message>
    <message>
        <source>Approaches</source>
        <translation>アプローチ</translation>
    </message>
    <message>
        <source>Numbers</source>
        <translation>数値</translation>
    </message>
    <message>
        <source>Labels</source>
        <translation>ラベル</translation>
    </message>
    <message>
        <source>Save labels</source>
        <translation>ラベルを保存</translation>
    </message>
    <message>
        <source>Another program has changed the case meanwhile. Put the corrected labels into the case as it is now? What you changed in the approaches since then is not in it.</source>
        <translation>その間に別のプログラムが症例を変えました。直したラベルを今の症例に入れますか。その後にアプローチで変えたことは含まれません。</translation>
    </message>
    <message>
        <source>Put them in</source>
        <translation>入れる</translation>
    </message>
    <message>
        <source>Saving the labels …</source>
        <translation>ラベルを保存しています…</translation>
    </message>
    <message>
        <source>Another program has changed the case meanwhile.</source>
        <translation>その間に別のプログラムが症例を変えました。</translation>
    </message>
    <message>
        <source>The labels are saved. Plans are made with them from now on.</source>
        <translation>ラベルを保存しました。これからの計画はこのラベルを使います。</translation>
    </message>
    <message>
        <source>Reading the case</source>
        <translation>症例を読んでいます</translation>
    </message>
    <message>
        <source>Making the demo patient</source>
        <translation>デモ患者を作っています</translation>
    </message>
    <message>
        <source>Making the aorta</source>
        <translation>大動脈を作っています</translation>
    </message>
    <message>
        <source>Taken back: %1</source>
        <translation>取り消しました：%1</translation>
    </message>
    <message>
        <source>Made again: %1</source>
        <translation>もう一度行いました：%1</translation>
    </message>
    <message>
        <source>Undo: %1</source>
        <translation>元に戻す：%1</translation>
    </message>
    <message>
        <source>Redo: %1</source>
        <translation>やり直す：%1</translation>
    </message>
    <message>
        <source>the last change of the points</source>
        <translation>直前の点の変更</translation>
    </message>
    <message>
        <source>the last place</source>
        <translation>直前の点</translation>
    </message>
    <message>
        <source>cut</source>
        <translation>切開</translation>
    </message>
    <message>
        <source>Another window %1 has this case open. Here you can look at it and plan it, but not change it. Close the other window, then look again. If its computer has failed, delete the file %2 beside the case.</source>
        <translation>別のウィンドウ（%1）がこの症例を開いています。ここでは見ることと計画はできますが、変えることはできません。そのウィンドウを閉じてから、もう一度確かめてください。そのコンピュータが止まっているときは、症例の横のファイル %2 を消してください。</translation>
    </message>
    <message>
        <source>on this computer</source>
        <translation>このコンピュータ</translation>
    </message>
    <message>
        <source>Look again</source>
        <translation>もう一度確かめる</translation>
    </message>
    <message>
        <source>Close the case?</source>
        <translation>症例を閉じますか</translation>
    </message>
    <message>
        <source>Cuts by hand cannot be saved now, and are lost when the window is closed. %1</source>
        <translation>手で加えた切開を今は保存できません。ウィンドウを閉じると失われます。%1</translation>
    </message>
    <message>
        <source>The cuts by hand are not saved. If you close now, they are lost. %1</source>
        <translation>手で加えた切開は保存されていません。今閉じると失われます。%1</translation>
    </message>
    <message>
        <source>The cuts are saved</source>
        <translation>切開を保存しました</translation>
    </message>
    <message>
        <source>The cuts are still not saved: %1</source>
        <translation>切開はまだ保存されていません: %1</translation>
    </message>
    <message>
        <source>The approaches are not saved, and are lost when the window is closed. %1</source>
        <translation>アプローチは保存されていません。ウィンドウを閉じると失われます。%1</translation>
    </message>
    <message>
        <source>Overwrite it</source>
        <translation>上書きする</translation>
    </message>
    <message>
        <source>Try again</source>
        <translation>もう一度試す</translation>
    </message>
    <message>
        <source>Open another case?</source>
        <translation>別の症例を開きますか</translation>
    </message>
    <message>
        <source>Reading %1</source>
        <translation>%1 を読んでいます</translation>
    </message>
    <message>
        <source>Preparing %1 for palpation …</source>
        <translation>%1の触診を準備しています…</translation>
    </message>
    <message>
        <source>The plan uses the labels as saved: the corrections are not saved yet.</source>
        <translation>計画は保存したラベルを使います。修正はまだ保存されていません。</translation>
    </message>
    <message>
        <source>Reading the patient …</source>
        <translation>患者を読んでいます…</translation>
    </message>
    <message>
        <source>Click the corners of the next area. Esc ends.</source>
        <translation>次の面積の角をクリックしてください。Esc で終わります。</translation>
    </message>
    <message>
        <source>Click the corners of the area. Enter begins another, Esc ends, Ctrl+Z takes a corner back.</source>
        <translation>面積の角をクリックしてください。Enter で次の面積、Esc で終了、Ctrl+Z で角を一つ戻します。</translation>
    </message>
    <message>
        <source>Click two places for a distance, a third for an angle. Esc ends, Ctrl+Z takes a place back.</source>
        <translation>距離は二点、角度は三点をクリックしてください。Esc で終了、Ctrl+Z で一点戻します。</translation>
    </message>
    <message>
        <source>Press O first: only the closed skin can be measured.</source>
        <translation>先に O を押してください。測れるのは閉じた皮膚だけです。</translation>
    </message>
    <message>
        <source>Click on the skin.</source>
        <translation>皮膚をクリックしてください。</translation>
    </message>
    <message>
        <source>Click on a slice.</source>
        <translation>断面をクリックしてください。</translation>
    </message>
    <message>
        <source>Click the next corner.</source>
        <translation>次の角をクリックしてください。</translation>
    </message>
    <message>
        <source>Click the second place.</source>
        <translation>二つめの点をクリックしてください。</translation>
    </message>
    <message>
        <source>The manual is not installed beside the program. It is also in the source, in docs/user.</source>
        <translation>マニュアルはプログラムと一緒に入っていません。ソースの docs/user にもあります。</translation>
    </message>
    <message>
        <source>Saving: %1 …</source>
        <translation>保存中：%1 …</translation>
    </message>
    <message>
        <source>Saving: %1 (%2 %)</source>
        <translation>保存中：%1（%2 %）</translation>
    </message>
    <message>
        <source>Open case</source>
        <translation>症例を開く</translation>
    </message>
    <message>
        <source>Case (case.json *.json)</source>
        <translation>症例 (case.json *.json)</translation>
    </message>
    <message>
        <source>Palpate</source>
        <translation>触診</translation>
    </message>
    <message>
        <source>Structure to palpate (a vessel gets a wall of 2 mm, filled with blood):</source>
        <translation>触診する構造（血管は血液で満たした厚さ 2 mm の壁になります）：</translation>
    </message>
    <message>
        <source>Save picture</source>
        <translation>画像を保存</translation>
    </message>
    <message>
        <source>Picture (*.png)</source>
        <translation>画像 (*.png)</translation>
    </message>
    <message>
        <source>Saved %1</source>
        <translation>保存しました：%1</translation>
    </message>
    <message>
        <source>Not saved: cancelled</source>
        <translation>保存していません：中止しました</translation>
    </message>
    <message>
        <source>Export the cut wall</source>
        <translation>切った体壁を書き出す</translation>
    </message>
    <message>
        <source>Mesh (*.vtu)</source>
        <translation>メッシュ (*.vtu)</translation>
    </message>
    <message>
        <source>Save the log</source>
        <translation>ログを保存</translation>
    </message>
    <message>
        <source>Text (*.txt)</source>
        <translation>テキスト (*.txt)</translation>
    </message>
    <message>
        <source>Save a movie of the plans</source>
        <translation>計画の動画を保存</translation>
    </message>
    <message>
        <source>Movie (*.webm)</source>
        <translation>動画 (*.webm)</translation>
    </message>
    <message>
        <source>Movie, and every frame as a picture (*.webm)</source>
        <translation>動画と、すべてのコマの画像 (*.webm)</translation>
    </message>
    <message>
        <source>Save the report</source>
        <translation>報告書を保存</translation>
    </message>
    <message>
        <source>Report (*.html)</source>
        <translation>報告書 (*.html)</translation>
    </message>
    <message>
        <source>The patient</source>
        <translation>患者</translation>
    </message>
    <message>
        <source>The list on the left has the approaches of this case; the blue line is the incision. Drag in the picture to turn it, use the wheel to zoom, 0 shows it as before.</source>
        <translation>左の一覧にこの症例のアプローチがあります。青い線が切開です。画像はドラッグで回り、ホイールで拡大縮小し、0 で元に戻ります。</translation>
    </message>
    <message>
        <source>Looking inside</source>
        <translation>中を見る</translation>
    </message>
    <message>
        <source>W looks through the wall, and hides it. Click on a bone or a vessel: the line at the bottom says what it is. V cuts the patient away; Shift and the wheel move the cut.</source>
        <translation>W で体壁を透かし、隠します。骨や血管をクリックすると、下の行に名前が出ます。V で患者を切り取って見ます。Shift とホイールで切り口が動きます。</translation>
    </message>
    <message>
        <source>Click on a slice: the others move there. The wheel goes from slice to slice, Shift+1 to Shift+4 change the greys. T makes the place where they meet the target.</source>
        <translation>断面をクリックすると、ほかの断面もそこへ動きます。ホイールで断面を送り、Shift+1 から Shift+4 で濃淡を変えます。T で交わる位置を標的にします。</translation>
    </message>
    <message>
        <source>The incision</source>
        <translation>切開</translation>
    </message>
    <message>
        <source>Cyan is the blade. Drag its end on the slice across the incision, and it goes deeper or another way. In the pictures in space, M moves the points of the incision, N adds an approach. Ctrl+Z takes everything back.</source>
        <translation>水色が刃です。切開に直交する断面でその先をドラッグすると、深さや向きが変わります。立体の画像では M で切開の点を動かし、N でアプローチを加えます。Ctrl+Z ですべて取り消せます。</translation>
    </message>
    <message>
        <source>The plan</source>
        <translation>計画</translation>
    </message>
    <message>
        <source>P cuts the wall, opens the wound with the retractor and measures what is seen. This takes one or two minutes; go on meanwhile. The numbers come on the right, the worst first; a red light means: do not do this.</source>
        <translation>P で体壁を切り、開創器で創を開き、見えるものを測ります。一、二分かかりますが、その間も操作できます。数値は悪いものから順に右に出ます。赤い印は「してはならない」の意味です。</translation>
    </message>
    <message>
        <source>What the surgeon sees</source>
        <translation>術者に見えるもの</translation>
    </message>
    <message>
        <source>This is the view through the incision from the best place of the eye; the target is green. O switches between before and after the cut, Ctrl+1 to Ctrl+6 show numbers as colours, 6 and 7 look through an endoscope.</source>
        <translation>最もよく見える目の位置から切開を通した眺めです。標的は緑です。O で切開の前後を切り替え、Ctrl+1 から Ctrl+6 で数値を色で示し、6 と 7 で内視鏡からのぞきます。</translation>
    </message>
    <message>
        <source>By hand</source>
        <translation>手で</translation>
    </message>
    <message>
        <source>K is the knife: draw a cut on the skin. H sets hooks on its edges; drag them, and the panel says which force they bear and how much of the target is seen. Esc puts the knife away.</source>
        <translation>K がメスです。皮膚の上に切開を描きます。H で創縁に鉤をかけ、ドラッグすると、かかる力と標的の見える割合がパネルに出ます。Esc でメスを置きます。</translation>
    </message>
    <message>
        <source>Deciding</source>
        <translation>決める</translation>
    </message>
    <message>
        <source>Shift+P plans all approaches, 5 compares them, Ctrl+F searches for better ones. F5 shows the plans in the case conference, Ctrl+R saves the report. F1 opens the manual at what is shown.</source>
        <translation>Shift+P ですべてを計画し、5 で比べ、Ctrl+F でよりよい切開を探します。F5 で症例カンファレンスに示し、Ctrl+R で報告書を保存します。F1 で今の画面についてのマニュアルを開きます。</translation>
    </message>
    <message>
        <source>Keep this view</source>
        <translation>この眺めを残す</translation>
    </message>
    <message>
        <source>Name of the view:</source>
        <translation>眺めの名前：</translation>
    </message>
    <message>
        <source>View %1</source>
        <translation>眺め %1</translation>
    </message>
    <message>
        <source>there is a view of this name already</source>
        <translation>この名前の眺めはすでにあります</translation>
    </message>
    <message>
        <source>Kept as a step of the conference: %1</source>
        <translation>カンファレンスの一場面として残しました：%1</translation>
    </message>
    <message>
        <source>Forget a view</source>
        <translation>眺めを消す</translation>
    </message>
    <message>
        <source>View:</source>
        <translation>眺め：</translation>
    </message>
    <message>
        <source>Forgotten: %1</source>
        <translation>消しました：%1</translation>
    </message>
    <message>
        <source>Chosen: %1</source>
        <translation>決定：%1</translation>
    </message>
    <message>
        <source>Cases whose answers are summed up</source>
        <translation>回答をまとめる症例</translation>
    </message>
    <message>
        <source>%1: nobody has answered yet</source>
        <translation>%1：まだ誰も答えていません</translation>
    </message>
    <message>
        <source>an incision is being drawn: finish or discard it first</source>
        <translation>切開を描いている途中です。先に確定するか捨ててください</translation>
    </message>
    <message>
        <source>Added: plan with P, compare with 5.</source>
        <translation>加えました。P で計画し、5 で比べます。</translation>
    </message>
    <message>
        <source>proposals</source>
        <translation>提案</translation>
    </message>
    <message>
        <source>Divide the space</source>
        <translation>肋間を切離</translation>
    </message>
    <message>
        <source>Saw across</source>
        <translation>胸骨を横断</translation>
    </message>
    <message>
        <source>a part of the line was not cut: %1</source>
        <translation>線の一部は切れませんでした：%1</translation>
    </message>
    <message>
        <source>a part of the ball was not removed: %1</source>
        <translation>球の一部は取り除けませんでした：%1</translation>
    </message>
    <message>
        <source>⚠ One side pulls with more than %1 N, and no retractor pulls this hard. Check whether the bone under the hooks is still uncut.</source>
        <translation>⚠ 片側の力が %1 N を超えています。これほど強く引く開創器はありません。鉤の下の骨が切れずに残っていないか確かめてください。</translation>
    </message>
    <message>
        <source>no rib breaks up to %1 mm</source>
        <translation>%1 mm まで肋骨は折れません</translation>
    </message>
    <message>
        <source>%1, no. %2</source>
        <translation>%1、その %2</translation>
    </message>
    <message>
        <source>The plan objects: %1</source>
        <translation>計画の警告：%1</translation>
    </message>
    <message>
        <source>⚠ The strain is above %1 %, and no tissue bears this strain. Open the wound less, or make the cut longer.</source>
        <translation>⚠ ひずみが %1 % を超えています。これに耐える組織はありません。開く幅を小さくするか、切開を長くしてください。</translation>
    </message>
    <message>
        <source>⚠ %1 meet. The hooks stop there, because lips do not pass through each other.</source>
        <translation>⚠ %1 がぶつかります。創縁は互いを通り抜けないので、鉤はそこで止まります。</translation>
    </message>
    <message>
        <source>⚠ The lips overlap by up to %1 mm. This view computes no contact between the lips; a plan with contact does.</source>
        <translation>⚠ 創縁が最大 %1 mm 重なっています。ここでは創縁どうしの接触を計算しません。接触つきの計画では計算します。</translation>
    </message>
    <message>
        <source>⚠ Do not rely on these forces: more of the wall moves than is computed well here. Rely on the force of the plan, at %1 mm.</source>
        <translation>⚠ この力を当てにしないでください。ここで正しく計算できる範囲より広く体壁が動いています。%1 mm での計画の力を使ってください。</translation>
    </message>
    <message>
        <source>⚠ Do not rely on these forces: more of the wall moves than is computed well here. Plan the approach for better ones.</source>
        <translation>⚠ この力を当てにしないでください。ここで正しく計算できる範囲より広く体壁が動いています。アプローチを計画すると、より正しい力がわかります。</translation>
    </message>
    <message>
        <source>more than %1 N</source>
        <translation>%1 N 超</translation>
    </message>
    <message>
        <source>holds the lips back with %1</source>
        <translation>%1 で創縁を押しとどめる</translation>
    </message>
    <message>
        <source>%1 and %2 on its blades: not at rest</source>
        <translation>ブレードに %1 と %2：釣り合っていない</translation>
    </message>
    <message>
        <source>%1 on each blade</source>
        <translation>各ブレードに %1</translation>
    </message>
    <message>
        <source>%1 open %2 of %3 mm, %4</source>
        <translation>%1 開き %2 mm（最大 %3 mm）、%4</translation>
    </message>
    <message>
        <source>pulls with %1 N</source>
        <translation>%1 N で引く</translation>
    </message>
    <message>
        <source>grip of %1 N/mm</source>
        <translation>把持 %1 N/mm</translation>
    </message>
    <message>
        <source>yields</source>
        <translation>すべる</translation>
    </message>
    <message>
        <source>holds up to %1 N</source>
        <translation>%1 N まで保持</translation>
    </message>
    <message>
        <source>%1 cm³, mostly %2</source>
        <translation>%1 cm³、おもに%2</translation>
    </message>
    <message>
        <source>%1 cm³ of %2</source>
        <translation>%2 %1 cm³</translation>
    </message>
    <message>
        <source>%1 cm² of wound</source>
        <translation>創面 %1 cm²</translation>
    </message>
    <message>
        <source>Taken out %1   %2</source>
        <translation>摘出 %1   %2</translation>
    </message>
    <message>
        <source>restored</source>
        <translation>復元済み</translation>
    </message>
    <message>
        <source>Cut %1   restored</source>
        <translation>切開 %1   復元済み</translation>
    </message>
    <message>
        <source>Cut %1   under the skin, %2, %3 cm²</source>
        <translation>切開 %1   皮下、%2、%3 cm²</translation>
    </message>
    <message>
        <source>Cut %1   as planned, %2 mm long, %3 mm deep</source>
        <translation>切開 %1   計画どおり、長さ %2 mm、深さ %3 mm</translation>
    </message>
    <message>
        <source>Cut %1   %2 mm long, %3 mm deep</source>
        <translation>切開 %1   長さ %2 mm、深さ %3 mm</translation>
    </message>
    <message>
        <source>forwards</source>
        <translation>前方へ</translation>
    </message>
    <message>
        <source>backwards</source>
        <translation>後方へ</translation>
    </message>
    <message>
        <source>to the right</source>
        <translation>右へ</translation>
    </message>
    <message>
        <source>to the left</source>
        <translation>左へ</translation>
    </message>
    <message>
        <source>undone</source>
        <translation>取り消し済み</translation>
    </message>
    <message>
        <source>Technical</source>
        <translation>技術情報</translation>
    </message>
    <message>
        <source>Numbers of mesh and solver, for whoever checks the program</source>
        <translation>プログラムを確かめる人のための、メッシュとソルバの数値</translation>
    </message>
    <message>
        <source>Depth of the cut below the skin</source>
        <translation>皮膚からの切開の深さ</translation>
    </message>
    <message>
        <source>Depth</source>
        <translation>深さ</translation>
    </message>
    <message>
        <source>Through the wall</source>
        <translation>体壁を貫く</translation>
    </message>
    <message>
        <source>The depth of the cut is the thickness of the wall where the stroke begins</source>
        <translation>切り始めの位置の体壁の厚さを切開の深さとする</translation>
    </message>
    <message>
        <source>Bone too (saw)</source>
        <translation>骨も切る（鋸）</translation>
    </message>
    <message>
        <source>The blade cuts bone and cartilage too. Without this option, bone and cartilage stay whole</source>
        <translation>骨と軟骨も切る。選ばなければ骨と軟骨は切れずに残る</translation>
    </message>
    <message>
        <source>Stretch of the soft tissue before the cut. A wound gapes more when the stretch is larger</source>
        <translation>切る前の軟部組織の張り。張りが大きいほど創は大きく開く</translation>
    </message>
    <message>
        <source>none</source>
        <translation>なし</translation>
    </message>
    <message>
        <source>Tension</source>
        <translation>組織の張り</translation>
    </message>
    <message>
        <source>What the Take out tool (X) removes where you press: a loose piece, or one tissue within this radius</source>
        <translation>「取り除く」(X) で押した所から取り除くもの：離れた片、またはこの半径内の一つの組織</translation>
    </message>
    <message>
        <source>a loose piece</source>
        <translation>離れた片</translation>
    </message>
    <message>
        <source>one tissue within %1 mm</source>
        <translation>%1 mm 以内の一つの組織</translation>
    </message>
    <message>
        <source>Cut as planned</source>
        <translation>計画どおり切る</translation>
    </message>
    <message>
        <source>Cut the planned incision, with all that the plan divides beyond the skin</source>
        <translation>計画した切開を、皮膚の下で切離する部分もすべて含めて切る</translation>
    </message>
    <message>
        <source>Saw the sternum across at the lower end of the last cut, under the skin</source>
        <translation>直前の切開の下端で、皮下の胸骨を横断する</translation>
    </message>
    <message>
        <source>Divide intercostal muscle and pleura beyond both ends of the last cut, under the skin</source>
        <translation>直前の切開の両端より先の肋間筋と胸膜を皮下で切離する</translation>
    </message>
    <message>
        <source>The approach divides nothing beyond the skin</source>
        <translation>このアプローチは皮膚切開より先を切離しません</translation>
    </message>
    <message>
        <source>Export…</source>
        <translation>書き出す…</translation>
    </message>
    <message>
        <source>Save the cut wall as VTU</source>
        <translation>切った体壁を VTU で保存する</translation>
    </message>
    <message>
        <source>Double-click a cut to go back (or forward) to the state just after the cut</source>
        <translation>切開をダブルクリックすると、その直後の状態に戻る（または進む）</translation>
    </message>
    <message>
        <source>Restore</source>
        <translation>復元</translation>
    </message>
    <message>
        <source>Prepare the wall and repeat these cuts</source>
        <translation>体壁を準備して、これらの切開を繰り返す</translation>
    </message>
    <message>
        <source>Discard</source>
        <translation>捨てる</translation>
    </message>
    <message>
        <source>Begin with an uncut wall. The file of the cuts is kept under another name</source>
        <translation>切っていない体壁から始める。切開のファイルは別の名前で残る</translation>
    </message>
    <message>
        <source>What the Hooks tool (H) sets where you press on the edge of a wound. A retractor has a second blade on the other lip; drag a blade, or turn the wheel over it, to crank it open</source>
        <translation>「鉤」(H) で創縁を押した所にかけるもの。開創器は反対側の創縁にもう一枚のブレードを持つ。ブレードをドラッグするか、その上でホイールを回すと開く</translation>
    </message>
    <message>
        <source>a hook</source>
        <translation>鉤</translation>
    </message>
    <message>
        <source>Set</source>
        <translation>かける物</translation>
    </message>
    <message>
        <source>Opening</source>
        <translation>開き</translation>
    </message>
    <message>
        <source>never</source>
        <translation>なし</translation>
    </message>
    <message>
        <source>Largest force of a hook. A hook yields (slips) above this force</source>
        <translation>鉤の最大の力。これを超えると鉤はすべる</translation>
    </message>
    <message>
        <source>Yield at</source>
        <translation>すべる力</translation>
    </message>
    <message>
        <source>Compute wide openings</source>
        <translation>大きな開創を計算</translation>
    </message>
    <message>
        <source>When the mouse rests, the tissue near the wound is computed for large movements. Without this option the lips swell, and forces are wrong, where a wound opens by more than 20 to 30 mm</source>
        <translation>マウスが止まると、創の近くの組織を大きな動きとして計算する。選ばなければ、20 〜 30 mm より大きく開く創で創縁がふくらみ、力が正しくなくなる</translation>
    </message>
    <message>
        <source>As planned</source>
        <translation>計画どおり</translation>
    </message>
    <message>
        <source>Set the hooks or the retractor of the approach and open them as planned</source>
        <translation>アプローチの鉤または開創器をかけ、計画どおり開く</translation>
    </message>
    <message>
        <source>Take off</source>
        <translation>外す</translation>
    </message>
    <message>
        <source>Remove the hook, or the retractor, that is selected in the list</source>
        <translation>一覧で選んだ鉤または開創器を外す</translation>
    </message>
    <message>
        <source>All off</source>
        <translation>すべて外す</translation>
    </message>
    <message>
        <source>Remove all hooks and retractors. The wound closes, or gapes from the tension of the tissue</source>
        <translation>すべての鉤と開創器を外す。創は閉じるか、組織の張りで開く</translation>
    </message>
    <message>
        <source>Add as an approach</source>
        <translation>アプローチに加える</translation>
    </message>
    <message>
        <source>Adds a copy of the approach that is opened by this retractor as it is now: its place, kind and opening</source>
        <translation>今の開創器の位置、種類、開きで開くアプローチの複製を加える</translation>
    </message>
    <message>
        <source>Select the hook tool with H. Press on the edge of a wound to set a hook or a retractor; drag it to pull</source>
        <translation>H で鉤を選ぶ。創縁を押して鉤または開創器をかけ、ドラッグして引く</translation>
    </message>
    <message>
        <source>Opens all planned hooks to this percentage of their planned force or displacement. A hook that you dragged with the mouse stays where it is</source>
        <translation>計画したすべての鉤を、計画した力または移動のこの割合まで開く。マウスで動かした鉤はそのまま残る</translation>
    </message>
    <message>
        <source>Pulls every hook away from the opposite lip by this distance, in mm on each side. Drag a single hook with the mouse</source>
        <translation>すべての鉤を反対側の創縁から、片側あたりこの距離 (mm) だけ引く。鉤は一本ずつマウスでドラッグできる</translation>
    </message>
    <message>
        <source>The approach has no hooks</source>
        <translation>このアプローチには鉤がありません</translation>
    </message>
    <message>
        <source>%1 on one side, %2 on the other</source>
        <translation>片側 %1、反対側 %2</translation>
    </message>
    <message>
        <source>strain %1 % (99th percentile) at (%2, %3, %4) mm</source>
        <translation>ひずみ %1 %（99 パーセンタイル）、位置 (%2, %3, %4) mm</translation>
    </message>
    <message>
        <source>The strain follows when the mouse rests</source>
        <translation>ひずみはマウスが止まると出ます</translation>
    </message>
    <message>
        <source>%1 %, as planned</source>
        <translation>%1 %（計画どおり）</translation>
    </message>
    <message>
        <source>The largest strain in the case. The other choices scale the strains of all tissues in proportion</source>
        <translation>症例の中で最も大きい張り。ほかの選択肢はすべての組織の張りを同じ割合で変える</translation>
    </message>
    <message>
        <source>The last session saved cuts that were undone. Restore them?</source>
        <translation>前回、取り消した切開が保存されています。復元しますか</translation>
    </message>
    <message>
        <source>Restore the cuts of the last session (%1)?</source>
        <translation>前回の切開（%1）を復元しますか</translation>
    </message>
    <message>
        <source>Restore the cuts of the last session (%1)? Answer on the right.</source>
        <translation>前回の切開（%1）を復元しますか。右側で答えてください。</translation>
    </message>
    <message>
        <source>Select the knife with K. Draw on the skin with the left button, and turn the camera with the right button.</source>
        <translation>K でメスを選びます。左ボタンで皮膚に描き、右ボタンで視点を回します。</translation>
    </message>
    <message>
        <source>Widest wound %1 mm</source>
        <translation>創の最大幅 %1 mm</translation>
    </message>
    <message>
        <source>Widest wound %1 mm, still opening</source>
        <translation>創の最大幅 %1 mm、まだ開いています</translation>
    </message>
    <message>
        <source>Preparing the wall for cutting</source>
        <translation>体壁の切開を準備しています</translation>
    </message>
    <message>
        <source>Answer on the right first: restore the cuts of the last session, or discard them</source>
        <translation>先に右側で、前回の切開を復元するか破棄するかを選んでください</translation>
    </message>
    <message>
        <source>the wall is not ready yet</source>
        <translation>体壁の準備がまだです</translation>
    </message>
    <message>
        <source>nothing can be taken out here</source>
        <translation>ここでは何も取り除けません</translation>
    </message>
    <message>
        <source>the knife cannot cut here</source>
        <translation>ここは切れません</translation>
    </message>
    <message>
        <source>this is the target: press on the wall</source>
        <translation>これは標的です。体壁を押してください</translation>
    </message>
    <message>
        <source>there is no tissue here: press on the wall</source>
        <translation>ここには組織がありません。体壁を押してください</translation>
    </message>
    <message>
        <source>the knife is beside the body: begin on the skin</source>
        <translation>メスが体から外れています。皮膚の上から始めてください</translation>
    </message>
    <message>
        <source>the hook is beside the body: set it on the edge of a wound</source>
        <translation>鉤が体から外れています。創縁にかけてください</translation>
    </message>
    <message>
        <source>What is seen cannot be measured: %1</source>
        <translation>見える割合を測れません：%1</translation>
    </message>
    <message>
        <source>Measuring what is seen of the target …</source>
        <translation>標的の見える割合を測っています…</translation>
    </message>
    <message>
        <source>Check these:</source>
        <translation>確かめてください：</translation>
    </message>
    <message>
        <source>Only estimated:</source>
        <translation>推定にすぎないもの：</translation>
    </message>
    <message>
        <source>Decided while reading:</source>
        <translation>読み込み中に決めたこと：</translation>
    </message>
    <message>
        <source>there is a case in this folder already: choose another folder</source>
        <translation>このフォルダにはすでに症例があります。別のフォルダを選んでください</translation>
    </message>
    <message>
        <source>about %1 s left in this step</source>
        <translation>この段階の残り約 %1 秒</translation>
    </message>
    <message>
        <source>about %1 min left in this step</source>
        <translation>この段階の残り約 %1 分</translation>
    </message>
    <message>
        <source>Import a study</source>
        <translation>検査を取り込む</translation>
    </message>
    <message>
        <source>These labels are of this CT</source>
        <translation>これらのラベルはこの CT のものである</translation>
    </message>
    <message>
        <source>Import</source>
        <translation>取り込む</translation>
    </message>
    <message>
        <source>Open the case</source>
        <translation>症例を開く</translation>
    </message>
    <message>
        <source>DICOM folder or disc, ZIP archive, NIfTI, NRRD, MetaImage or VTI file</source>
        <translation>DICOM のフォルダやディスク、ZIP、NIfTI、NRRD、MetaImage、VTI のファイル</translation>
    </message>
    <message>
        <source>Folder…</source>
        <translation>フォルダ…</translation>
    </message>
    <message>
        <source>File…</source>
        <translation>ファイル…</translation>
    </message>
    <message>
        <source>Find bones, lungs, heart, vessels and the layers of the wall in the CT (chest)</source>
        <translation>CT から骨、肺、心臓、血管、胸壁の層を見つける（胸部）</translation>
    </message>
    <message>
        <source>Label files</source>
        <translation>ラベルのファイル</translation>
    </message>
    <message>
        <source>Add label file…</source>
        <translation>ラベルのファイルを加える…</translation>
    </message>
    <message>
        <source>Add labels</source>
        <translation>ラベルを加える</translation>
    </message>
    <message>
        <source>Label maps (*.nrrd *.seg.nrrd *.nii *.nii.gz *.mha *.mhd *.vti *.dcm);;All files (*)</source>
        <translation>ラベル (*.nrrd *.seg.nrrd *.nii *.nii.gz *.mha *.mhd *.vti *.dcm);;すべてのファイル (*)</translation>
    </message>
    <message>
        <source>Add folder of masks…</source>
        <translation>マスクのフォルダを加える…</translation>
    </message>
    <message>
        <source>Add a folder of masks</source>
        <translation>マスクのフォルダを加える</translation>
    </message>
    <message>
        <source>Names as in the files</source>
        <translation>ファイルのとおりの名前</translation>
    </message>
    <message>
        <source>Names of %1</source>
        <translation>%1 の名前</translation>
    </message>
    <message>
        <source>Study</source>
        <translation>検査</translation>
    </message>
    <message>
        <source>Series</source>
        <translation>シリーズ</translation>
    </message>
    <message>
        <source>Folder of the case</source>
        <translation>症例のフォルダ</translation>
    </message>
    <message>
        <source>Findings of the import</source>
        <translation>取り込みの結果</translation>
    </message>
    <message>
        <source>Folder or disc of the study</source>
        <translation>検査のフォルダまたはディスク</translation>
    </message>
    <message>
        <source>Archive or image of the study</source>
        <translation>検査のアーカイブまたは画像</translation>
    </message>
    <message>
        <source>Studies (*.zip DICOMDIR *.dcm *.nii *.nii.gz *.nrrd *.nhdr *.mha *.mhd *.vti);;All files (*)</source>
        <translation>検査 (*.zip DICOMDIR *.dcm *.nii *.nii.gz *.nrrd *.nhdr *.mha *.mhd *.vti);;すべてのファイル (*)</translation>
    </message>
    <message>
        <source>Looking through the study</source>
        <translation>検査を調べています</translation>
    </message>
    <message>
        <source>This study has no CT: only slices of a CT can be imported.</source>
        <translation>この検査には CT がありません。取り込めるのは CT の断面だけです。</translation>
    </message>
    <message>
        <source>Only slices of a CT can be imported.</source>
        <translation>取り込めるのは CT の断面だけです。</translation>
    </message>
    <message>
        <source>Importing</source>
        <translation>取り込んでいます</translation>
    </message>
    <message>
        <source>The case was written to %1</source>
        <translation>症例を書き込みました：%1</translation>
    </message>
    <message>
        <source>There is nothing to check.</source>
        <translation>確かめることはありません。</translation>
    </message>
    <message>
        <source>Cancelling</source>
        <translation>中止しています</translation>
    </message>
    <message>
        <source>Plan an incision: draw it on the patient's skin, open it, and see what the surgeon will see.</source>
        <translation>切開を計画します。患者の皮膚に切開を描き、開き、術者に見えるものを見ます。</translation>
    </message>
    <message>
        <source>Begin</source>
        <translation>始める</translation>
    </message>
    <message>
        <source>CT from a DICOM folder, disc, ZIP or image file</source>
        <translation>DICOM のフォルダ、ディスク、ZIP、画像ファイルの CT</translation>
    </message>
    <message>
        <source>Open a case…</source>
        <translation>症例を開く…</translation>
    </message>
    <message>
        <source>A case that was imported before</source>
        <translation>取り込み済みの症例</translation>
    </message>
    <message>
        <source>New demo patient</source>
        <translation>新しいデモ患者</translation>
    </message>
    <message>
        <source>A made-up chest with an aneurysm and three approaches</source>
        <translation>動脈瘤と三つのアプローチを持つ、作られた胸部</translation>
    </message>
    <message>
        <source>See in eight steps what this window does, with a demo patient</source>
        <translation>このウィンドウでできることを、デモ患者で八つの場面で見る</translation>
    </message>
    <message>
        <source>Palpation trainer</source>
        <translation>触診の練習</translation>
    </message>
    <message>
        <source>Feel a beating aortic arch with a hardened wall</source>
        <translation>壁が硬くなった拍動する大動脈弓に触れる</translation>
    </message>
    <message>
        <source>Recent cases</source>
        <translation>最近の症例</translation>
    </message>
    <message>
        <source>Cases that you open are listed here. You can also drop a case, a folder of images or a ZIP file on this window.</source>
        <translation>開いた症例がここに並びます。症例、画像のフォルダ、ZIP ファイルをこのウィンドウに落とすこともできます。</translation>
    </message>
    <message>
        <source>series without a name</source>
        <translation>名前のないシリーズ</translation>
    </message>
    <message>
        <source>Patient %1: %2</source>
        <translation>患者 %1：%2</translation>
    </message>
    <message>
        <source>there is no such file or folder</source>
        <translation>そのファイルまたはフォルダはありません</translation>
    </message>
    <message>
        <source>%1 voxels have no label now. Paint another label there.</source>
        <translation>%1 ボクセルのラベルがなくなりました。そこに別のラベルを塗ってください。</translation>
    </message>
    <message>
        <source>Reading the labels …</source>
        <translation>ラベルを読んでいます…</translation>
    </message>
    <message>
        <source>Labels can be corrected where the case has a CT.</source>
        <translation>ラベルを直せるのは CT のある症例です。</translation>
    </message>
    <message>
        <source>The labels cannot be read: %1</source>
        <translation>ラベルを読めません：%1</translation>
    </message>
    <message>
        <source>Corrections of labels were not saved. Open Labels (C) to make them again.</source>
        <translation>ラベルの修正が保存されていません。ラベル (C) を開くともう一度行えます。</translation>
    </message>
    <message>
        <source>Corrections of labels</source>
        <translation>ラベルの修正</translation>
    </message>
    <message>
        <source>Corrections of labels were made and not saved (%1; the last: %2). Make them again?</source>
        <translation>保存されていないラベルの修正があります（%1、最後は%2）。もう一度行いますか</translation>
    </message>
    <message>
        <source>Make them again</source>
        <translation>もう一度行う</translation>
    </message>
    <message>
        <source>Forget them</source>
        <translation>捨てる</translation>
    </message>
    <message>
        <source>Join labels</source>
        <translation>ラベルを合わせる</translation>
    </message>
    <message>
        <source>Make %1 a part of</source>
        <translation>%1を次の一部にする</translation>
    </message>
    <message>
        <source>Rename a label</source>
        <translation>ラベルの名前を変える</translation>
    </message>
    <message>
        <source>New name of %1</source>
        <translation>%1の新しい名前</translation>
    </message>
    <message>
        <source>Working …</source>
        <translation>処理しています…</translation>
    </message>
    <message>
        <source>Done: %1</source>
        <translation>済みました：%1</translation>
    </message>
    <message>
        <source>There is nothing to change.</source>
        <translation>変えるものはありません。</translation>
    </message>
    <message>
        <source>a target, such as an aneurysm</source>
        <translation>標的（動脈瘤など）</translation>
    </message>
    <message>
        <source>a structure at risk, such as a vessel</source>
        <translation>損傷してはならない構造（血管など）</translation>
    </message>
    <message>
        <source>a bone of the wall, such as a rib</source>
        <translation>胸壁の骨（肋骨など）</translation>
    </message>
    <message>
        <source>an organ that hides the view</source>
        <translation>視野を遮る臓器</translation>
    </message>
    <message>
        <source>New label</source>
        <translation>新しいラベル</translation>
    </message>
    <message>
        <source>Name, such as aneurysm or rib_left_4</source>
        <translation>名前（aneurysm、rib_left_4 など）</translation>
    </message>
    <message>
        <source>What is it?</source>
        <translation>何ですか</translation>
    </message>
    <message>
        <source>Paint</source>
        <translation>塗る</translation>
    </message>
    <message>
        <source>Drag on a slice to give it the chosen label</source>
        <translation>断面をドラッグして、選んだラベルを塗る</translation>
    </message>
    <message>
        <source>Erase</source>
        <translation>消す</translation>
    </message>
    <message>
        <source>Drag to take the chosen label away: it becomes what lies beside it</source>
        <translation>ドラッグして選んだラベルを消す。そこは隣のものになる</translation>
    </message>
    <message>
        <source>Fill</source>
        <translation>満たす</translation>
    </message>
    <message>
        <source>Click into a region of a slice to give it the chosen label</source>
        <translation>断面の領域をクリックして、選んだラベルで満たす</translation>
    </message>
    <message>
        <source>Radius of the brush</source>
        <translation>筆の半径</translation>
    </message>
    <message>
        <source>In all slices within reach</source>
        <translation>届くすべての断面に</translation>
    </message>
    <message>
        <source>The brush is a ball, and not a disc in this slice</source>
        <translation>筆をこの断面の円でなく球にする</translation>
    </message>
    <message>
        <source>Keep bones</source>
        <translation>骨を残す</translation>
    </message>
    <message>
        <source>Bone and cartilage are not painted over</source>
        <translation>骨と軟骨には塗らない</translation>
    </message>
    <message>
        <source>Smooth</source>
        <translation>滑らかに</translation>
    </message>
    <message>
        <source>Smooth the surface of the label</source>
        <translation>ラベルの表面を滑らかにする</translation>
    </message>
    <message>
        <source>Largest piece</source>
        <translation>最大の片</translation>
    </message>
    <message>
        <source>Drop the islands of the label</source>
        <translation>離れた小さな片を捨てる</translation>
    </message>
    <message>
        <source>Between slices</source>
        <translation>断面の間</translation>
    </message>
    <message>
        <source>Fill the axial slices between those in which it was drawn</source>
        <translation>描いた横断面の間の断面を満たす</translation>
    </message>
    <message>
        <source>Confirm</source>
        <translation>確認済みに</translation>
    </message>
    <message>
        <source>The label was estimated; you have checked it</source>
        <translation>推定されたラベルを確かめたことにする</translation>
    </message>
    <message>
        <source>Join with…</source>
        <translation>合わせる…</translation>
    </message>
    <message>
        <source>Make the label a part of another one</source>
        <translation>ラベルを別のラベルの一部にする</translation>
    </message>
    <message>
        <source>Rename…</source>
        <translation>名前を変える…</translation>
    </message>
    <message>
        <source>Give the label another name, such as the number of a rib</source>
        <translation>ラベルに別の名前（肋骨の番号など）をつける</translation>
    </message>
    <message>
        <source>New label…</source>
        <translation>新しいラベル…</translation>
    </message>
    <message>
        <source>Add a label, to be painted</source>
        <translation>これから塗るラベルを加える</translation>
    </message>
    <message>
        <source>Take all corrections back</source>
        <translation>修正をすべて取り消す</translation>
    </message>
    <message>
        <source>Write the labels into the case; plans are made anew</source>
        <translation>ラベルを症例に書き込む。計画は作り直しになる</translation>
    </message>
    <message>
        <source>Brush of %1 mm radius</source>
        <translation>筆の半径 %1 mm</translation>
    </message>
    <message>
        <source>Corrected, not saved. Plans use the labels after Save labels.</source>
        <translation>修正は未保存です。「ラベルを保存」の後、計画に使われます。</translation>
    </message>
    <message>
        <source>Choose a label, then paint on a slice. The wheel turns the slices.</source>
        <translation>ラベルを選び、断面に塗ってください。ホイールで断面を送ります。</translation>
    </message>
    <message>
        <source>%1, %2 ml (estimated)</source>
        <translation>%1、%2 ml（推定）</translation>
    </message>
    <message>
        <source>%1, %2 ml</source>
        <translation>%1、%2 ml</translation>
    </message>
    <message>
        <source>This is bone. Take the tick off Keep bones to fill it.</source>
        <translation>これは骨です。満たすには「骨を残す」の印を外してください。</translation>
    </message>
    <message>
        <source>Paint on a slice.</source>
        <translation>断面に塗ってください。</translation>
    </message>
    <message>
        <source>Choose a label in the list first.</source>
        <translation>先に一覧でラベルを選んでください。</translation>
    </message>
    <message>
        <source>Median sternotomy</source>
        <translation>胸骨正中切開</translation>
    </message>
    <message>
        <source>Upper hemisternotomy, J to the right</source>
        <translation>胸骨部分切開（上部 J 字、右）</translation>
    </message>
    <message>
        <source>Upper hemisternotomy, J to the left</source>
        <translation>胸骨部分切開（上部 J 字、左）</translation>
    </message>
    <message>
        <source>Upper hemisternotomy, T</source>
        <translation>胸骨部分切開（上部 T 字）</translation>
    </message>
    <message>
        <source>Thoracotomy between two ribs</source>
        <translation>肋間開胸</translation>
    </message>
    <message>
        <source>Left posterolateral thoracotomy</source>
        <translation>左後側方開胸</translation>
    </message>
    <message>
        <source>Left anterior mini-thoracotomy (MIDCAB)</source>
        <translation>左前方小開胸 (MIDCAB)</translation>
    </message>
    <message>
        <source>Right anterior mini-thoracotomy (aortic valve)</source>
        <translation>右前方小開胸（大動脈弁）</translation>
    </message>
    <message>
        <source>Right lateral mini-thoracotomy (mitral valve)</source>
        <translation>右側方小開胸（僧帽弁）</translation>
    </message>
    <message>
        <source>2 hooks</source>
        <translation>鉤 2 本</translation>
    </message>
    <message>
        <source>4 hooks</source>
        <translation>鉤 4 本</translation>
    </message>
    <message>
        <source>8 hooks</source>
        <translation>鉤 8 本</translation>
    </message>
    <message>
        <source>One blade on each lip, held by hand</source>
        <translation>両創縁に手持ちのブレード一枚ずつ</translation>
    </message>
    <message>
        <source>as it is</source>
        <translation>今のまま</translation>
    </message>
    <message>
        <source>%1 (estimated)</source>
        <translation>%1（推定）</translation>
    </message>
    <message>
        <source>%1 (assumed place)</source>
        <translation>%1（想定位置）</translation>
    </message>
    <message>
        <source>left mammary artery</source>
        <translation>左内胸動脈</translation>
    </message>
    <message>
        <source>right mammary artery</source>
        <translation>右内胸動脈</translation>
    </message>
    <message>
        <source>left neurovascular bundle %1</source>
        <translation>左第 %1 肋間神経血管束</translation>
    </message>
    <message>
        <source>right neurovascular bundle %1</source>
        <translation>右第 %1 肋間神経血管束</translation>
    </message>
    <message>
        <source>mammary arteries, and vessels and nerves under the ribs, are not seen in the image: they are assumed where they usually are</source>
        <translation>内胸動脈と、肋骨の下の血管・神経は画像に見えません：通常の位置にあるものと想定します</translation>
    </message>
    <message>
        <source>New approach</source>
        <translation>新しいアプローチ</translation>
    </message>
    <message>
        <source>New approach through the drawn incision</source>
        <translation>描いた切開による新しいアプローチ</translation>
    </message>
    <message>
        <source>Target and opening</source>
        <translation>標的と開創</translation>
    </message>
    <message>
        <source>named after the approach</source>
        <translation>アプローチの名前になります</translation>
    </message>
    <message>
        <source>Name</source>
        <translation>名前</translation>
    </message>
    <message>
        <source>Change</source>
        <translation>変える</translation>
    </message>
    <message>
        <source>Add approach</source>
        <translation>アプローチを加える</translation>
    </message>
    <message>
        <source>space %1</source>
        <translation>第 %1 肋間</translation>
    </message>
    <message>
        <source>space </source>
        <translation>第 </translation>
    </message>
    <message>
        <source>Left</source>
        <translation>左</translation>
    </message>
    <message>
        <source>Right</source>
        <translation>右</translation>
    </message>
    <message>
        <source>Approach</source>
        <translation>アプローチ</translation>
    </message>
    <message>
        <source>Between ribs</source>
        <translation>肋間</translation>
    </message>
    <message>
        <source>Side</source>
        <translation>側</translation>
    </message>
    <message>
        <source>Soft tissue along the incision</source>
        <translation>切開に沿う軟部組織</translation>
    </message>
    <message>
        <source>The space between the ribs, beyond the incision too</source>
        <translation>肋間を、切開より先まで</translation>
    </message>
    <message>
        <source>Soft tissue and the bone under the incision (saw)</source>
        <translation>軟部組織と切開の下の骨（鋸）</translation>
    </message>
    <message>
        <source>through the wall</source>
        <translation>体壁を貫く</translation>
    </message>
    <message>
        <source>Lungs and pericardium are held aside</source>
        <translation>肺と心膜を圧排する</translation>
    </message>
    <message>
        <source>Divides</source>
        <translation>切離する範囲</translation>
    </message>
    <message>
        <source>Depth of the cut</source>
        <translation>切開の深さ</translation>
    </message>
    <message>
        <source>The same as now: %1</source>
        <translation>今のまま：%1</translation>
    </message>
    <message>
        <source>Nothing yet (only cut)</source>
        <translation>まだなし（切るだけ）</translation>
    </message>
    <message>
        <source>Target</source>
        <translation>標的</translation>
    </message>
    <message>
        <source>Opened by</source>
        <translation>開く物</translation>
    </message>
    <message>
        <source>the space that suits the target</source>
        <translation>標的に合う肋間</translation>
    </message>
    <message>
        <source>Added: %1</source>
        <translation>加えました：%1</translation>
    </message>
    <message>
        <source>Added %1</source>
        <translation>加えました：%1</translation>
    </message>
    <message>
        <source>Click the points of the incision on the skin, or drag along it. Enter ends, Esc discards.</source>
        <translation>皮膚の上で切開の点をクリックするか、なぞってください。Enter で確定、Esc で捨てます。</translation>
    </message>
    <message>
        <source>Drag the points of the incision. Enter ends, Esc leaves the incision as it was.</source>
        <translation>切開の点をドラッグしてください。Enter で確定、Esc で元のままにします。</translation>
    </message>
    <message>
        <source>Click further points of the incision.</source>
        <translation>切開の次の点をクリックしてください。</translation>
    </message>
    <message>
        <source>%1 points, %2 mm. Enter ends, Esc discards, Ctrl+Z takes the last change back.</source>
        <translation>%1 点、%2 mm。Enter で確定、Esc で捨て、Ctrl+Z で直前の変更を取り消します。</translation>
    </message>
    <message>
        <source>move the incision of %1</source>
        <translation>%1の切開を動かす</translation>
    </message>
    <message>
        <source>Moved the incision of %1</source>
        <translation>%1の切開を動かしました</translation>
    </message>
    <message>
        <source>An incision needs at least two points.</source>
        <translation>切開には少なくとも二点が必要です。</translation>
    </message>
    <message>
        <source>a ball, as it is</source>
        <translation>球（今のまま）</translation>
    </message>
    <message>
        <source>%1, as it is</source>
        <translation>%1（今のまま）</translation>
    </message>
    <message>
        <source>change %1</source>
        <translation>%1を変える</translation>
    </message>
    <message>
        <source>Changed %1</source>
        <translation>%1を変えました</translation>
    </message>
    <message>
        <source>set the blade of %1</source>
        <translation>%1の刃を決める</translation>
    </message>
    <message>
        <source>The blade goes %1 mm deep%2</source>
        <translation>刃の深さは %1 mm%2</translation>
    </message>
    <message>
        <source>The slices have no labels: nothing is known of this place.</source>
        <translation>断面にラベルがありません。この位置のことはわかりません。</translation>
    </message>
    <message>
        <source>choose the target</source>
        <translation>標的を選ぶ</translation>
    </message>
    <message>
        <source>The target is the %1</source>
        <translation>標的は%1です</translation>
    </message>
    <message>
        <source>Added: %1, opened by %2 mm</source>
        <translation>加えました：%1、開き %2 mm</translation>
    </message>
    <message>
        <source>There is nothing to add beside %1</source>
        <translation>%1の隣に加えられるものはありません</translation>
    </message>
    <message>
        <source>add what lies beside %1</source>
        <translation>%1の隣を加える</translation>
    </message>
    <message>
        <source>Added %1. Shift+P plans, 5 compares.</source>
        <translation>加えました：%1。Shift+P で計画し、5 で比べます。</translation>
    </message>
    <message>
        <source>Removed %1. Ctrl+Z brings it back.</source>
        <translation>消しました：%1。Ctrl+Z で戻ります。</translation>
    </message>
    <message>
        <source>add %1</source>
        <translation>%1を加える</translation>
    </message>
    <message>
        <source>rename %1</source>
        <translation>%1の名前を変える</translation>
    </message>
    <message>
        <source>Renamed: %1</source>
        <translation>名前を変えました：%1</translation>
    </message>
    <message>
        <source>Nothing was changed.</source>
        <translation>何も変わっていません。</translation>
    </message>
    <message>
        <source>remove %1</source>
        <translation>%1を消す</translation>
    </message>
    <message>
        <source>waiting to be planned</source>
        <translation>計画待ち</translation>
    </message>
    <message>
        <source>being planned</source>
        <translation>計画中</translation>
    </message>
    <message>
        <source>being cancelled</source>
        <translation>中止中</translation>
    </message>
    <message>
        <source>failed: %1</source>
        <translation>失敗：%1</translation>
    </message>
    <message>
        <source>%1 seen, %2 N, %3 cm²</source>
        <translation>見える %1、%2 N、%3 cm²</translation>
    </message>
    <message>
        <source>%1; chosen by %2</source>
        <translation>%1、決定：%2</translation>
    </message>
    <message>
        <source>%1 mm long, %2</source>
        <translation>長さ %1 mm、%2</translation>
    </message>
    <message>
        <source>%1 hook</source>
        <translation>鉤 %1 本</translation>
    </message>
    <message>
        <source>%1 hooks</source>
        <translation>鉤 %1 本</translation>
    </message>
    <message>
        <source>Comparison of the planned approaches</source>
        <translation>計画したアプローチの比較</translation>
    </message>
    <message>
        <source>Drag a point of the incision.</source>
        <translation>切開の点をドラッグしてください。</translation>
    </message>
    <message>
        <source>There is no skin: click on the patient.</source>
        <translation>ここに皮膚はありません。患者をクリックしてください。</translation>
    </message>
    <message>
        <source>Sight</source>
        <translation>視野</translation>
    </message>
    <message>
        <source>Structure that the surgeon wants to see.</source>
        <translation>術者が見たい構造。</translation>
    </message>
    <message>
        <source>Estimated</source>
        <translation>推定</translation>
    </message>
    <message>
        <source>Labels that the image does not show. They were estimated from their surroundings.</source>
        <translation>画像からはわからず、周囲から推定されたラベル。</translation>
    </message>
    <message>
        <source>Seen with organs %1 mm higher</source>
        <translation>臓器が %1 mm 頭側のとき</translation>
    </message>
    <message>
        <source>Seen by the best eye with the organs nearer to the head, as in expiration.</source>
        <translation>呼気のように臓器が頭側に寄ったときに、最良の目に見える割合。</translation>
    </message>
    <message>
        <source>Seen past a lung of %1% of its volume</source>
        <translation>肺が体積の %1 % のとき</translation>
    </message>
    <message>
        <source>Seen supine</source>
        <translation>仰臥位のとき</translation>
    </message>
    <message>
        <source>Seen with the left side up by %1 degrees</source>
        <translation>左側を %1 度上げたとき</translation>
    </message>
    <message>
        <source>Seen with the right side up by %1 degrees</source>
        <translation>右側を %1 度上げたとき</translation>
    </message>
    <message>
        <source>Seen lying on the right side</source>
        <translation>右側臥位のとき</translation>
    </message>
    <message>
        <source>Seen lying on the left side</source>
        <translation>左側臥位のとき</translation>
    </message>
    <message>
        <source>Seen by the best eye that looks down at the wound by at least %1 degrees, with the patient so on the table. Organs sink with gravity.</source>
        <translation>患者がこの体位で手術台にいるとき、水平から %1 度以上見下ろす最良の目に見える割合。臓器は重力で沈みます。</translation>
    </message>
    <message>
        <source>supine</source>
        <translation>仰臥位</translation>
    </message>
    <message>
        <source>with the left side up by %1 degrees</source>
        <translation>左側を %1 度上げた体位</translation>
    </message>
    <message>
        <source>with the right side up by %1 degrees</source>
        <translation>右側を %1 度上げた体位</translation>
    </message>
    <message>
        <source>lying on the right side</source>
        <translation>右側臥位</translation>
    </message>
    <message>
        <source>lying on the left side</source>
        <translation>左側臥位</translation>
    </message>
    <message>
        <source>From above the table %1 % is seen %2, and %3 % %4.</source>
        <translation>手術台の上からは、%2で %1 %、%4で %3 % が見えます。</translation>
    </message>
    <message>
        <source>the patient supine</source>
        <translation>仰臥位の場合</translation>
    </message>
    <message>
        <source>the patient on the other side</source>
        <translation>切開と反対の側臥位の場合</translation>
    </message>
    <message>
        <source>Position on the table: from above the table the best eye sees %1.</source>
        <translation>手術台上の体位：手術台の上からの最良の目には %1 が見えます。</translation>
    </message>
    <message>
        <source>the incision's side up by %1 degrees</source>
        <translation>切開側を %1 度上げた場合</translation>
    </message>
    <message>
        <source>Seen past a lung of %1 % of its volume</source>
        <translation>肺が体積の %1 % のとき</translation>
    </message>
    <message>
        <source>Seen by the best eye when the lung that is held aside keeps another share of its volume than the assumed %1 %.</source>
        <translation>圧排した肺が、仮定した %1 % と違う体積を保つときに、最良の目に見える割合。</translation>
    </message>
    <message>
        <source>Bone in sight</source>
        <translation>視野の骨</translation>
    </message>
    <message>
        <source>Bones that block the view of the target.</source>
        <translation>標的への視線を遮る骨。</translation>
    </message>
    <message>
        <source>Held aside</source>
        <translation>圧排する臓器</translation>
    </message>
    <message>
        <source>Organs that are held aside in this approach.</source>
        <translation>このアプローチで圧排する臓器。</translation>
    </message>
    <message>
        <source>Hidden by %1</source>
        <translation>%1に隠れる</translation>
    </message>
    <message>
        <source>Share of the target that this structure hides first from the best eye.</source>
        <translation>最良の目から見て、この構造が最初に隠す標的の割合。</translation>
    </message>
    <message>
        <source>Cut to %1</source>
        <translation>切開面から%1まで</translation>
    </message>
    <message>
        <source>passes through it</source>
        <translation>貫く</translation>
    </message>
    <message>
        <source>Shortest distance from the cut to this structure at risk, before opening.</source>
        <translation>開創前の、切開面からこの危険構造までの最短距離。</translation>
    </message>
    <message>
        <source>Shortest distance from this instrument, where it stands in the opened wound, to this structure at risk, where the CT shows it.</source>
        <translation>開いた創にあるこの器械から、CT が示す位置のこの構造までの最短距離。</translation>
    </message>
    <message>
        <source>Opening possible</source>
        <translation>開けるか</translation>
    </message>
    <message>
        <source>Without a fracture</source>
        <translation>骨折なしでは</translation>
    </message>
    <message>
        <source>about %1 mm</source>
        <translation>約 %1 mm</translation>
    </message>
    <message>
        <source>Largest opening of the hooks at which no rib breaks: an estimate in proportion to the opening.</source>
        <translation>肋骨が折れない最大の開き。開きに比例するとした推定。</translation>
    </message>
    <message>
        <source>Most loaded rib</source>
        <translation>最も力のかかる肋骨</translation>
    </message>
    <message>
        <source>Moment in %1 over the moment at which tested ribs broke.</source>
        <translation>%1の曲げモーメントを、試験で肋骨が折れたモーメントで割ったもの。</translation>
    </message>
    <message>
        <source>... by tissue values</source>
        <translation>… 組織の値による</translation>
    </message>
    <message>
        <source>not known</source>
        <translation>不明</translation>
    </message>
    <message>
        <source>%1. One standard deviation of the tissues' published values.</source>
        <translation>%1。公表された組織の値の一標準偏差。</translation>
    </message>
    <message>
        <source>Stiffness of bones</source>
        <translation>骨の硬さ</translation>
    </message>
    <message>
        <source>Young's moduli of the ribs and cartilages in the wall; the report has a table.</source>
        <translation>胸壁の肋骨と軟骨のヤング率。報告書に表がある。</translation>
    </message>
    <message>
        <source>... after minutes</source>
        <translation>… 数分後</translation>
    </message>
    <message>
        <source>not applicable</source>
        <translation>当てはまらない</translation>
    </message>
    <message>
        <source>... at the last turn</source>
        <translation>… 最後の一回しで</translation>
    </message>
    <message>
        <source>... after %1 min</source>
        <translation>… %1 分後</translation>
    </message>
    <message>
        <source>about %1 N</source>
        <translation>約 %1 N</translation>
    </message>
    <message>
        <source>Held at this opening: %1 to %2 N between animals; %3.</source>
        <translation>この開きを保つ力。動物により %1 〜 %2 N。%3。</translation>
    </message>
    <message>
        <source>Strain of %1</source>
        <translation>%1のひずみ</translation>
    </message>
    <message>
        <source>Largest mean over balls of %1 mm radius: %2.</source>
        <translation>半径 %1 mm の球での平均の最大：%2。</translation>
    </message>
    <message>
        <source>Tearing</source>
        <translation>裂け</translation>
    </message>
    <message>
        <source>expected</source>
        <translation>起こる見込み</translation>
    </message>
    <message>
        <source>possible</source>
        <translation>ありうる</translation>
    </message>
    <message>
        <source>Force and strain</source>
        <translation>力とひずみ</translation>
    </message>
    <message>
        <source>Rupture</source>
        <translation>断裂</translation>
    </message>
    <message>
        <source>Speed of opening</source>
        <translation>開く速さ</translation>
    </message>
    <message>
        <source>fast</source>
        <translation>速い</translation>
    </message>
    <message>
        <source>Retractor, %1</source>
        <translation>開創器、%1</translation>
    </message>
    <message>
        <source>Off its line: left lip</source>
        <translation>左の創縁のずれ</translation>
    </message>
    <message>
        <source>Off its line: right lip</source>
        <translation>右の創縁のずれ</translation>
    </message>
    <message>
        <source>Largest distance of the skin's edge from the line of its hooks, in the middle part of the incision; %1 mm in the mean.</source>
        <translation>切開の中央部で、鉤を結ぶ線から皮膚の縁までの最大の距離。平均 %1 mm。</translation>
    </message>
    <message>
        <source>Hook %1</source>
        <translation>鉤 %1</translation>
    </message>
    <message>
        <source>Bears on %1.</source>
        <translation>%1にかかる。</translation>
    </message>
    <message>
        <source>Kind of the instrument, and its opening or force.</source>
        <translation>器械の種類と、開きまたは力。</translation>
    </message>
    <message>
        <source>Kind</source>
        <translation>種類</translation>
    </message>
    <message>
        <source>Steps of the crank. Slower steps take less force.</source>
        <translation>ラックの回し方。ゆっくり回すほど力は小さい。</translation>
    </message>
    <message>
        <source>The hook pulls its lip with this force. The opening follows from the force.</source>
        <translation>鉤はこの力で創縁を引く。開きは力で決まる。</translation>
    </message>
    <message>
        <source>The hook moves its lip by this distance.</source>
        <translation>鉤は創縁をこの距離だけ動かす。</translation>
    </message>
    <message>
        <source>The hook moves by this distance. Its lip may move less.</source>
        <translation>鉤はこの距離だけ動く。創縁の動きはこれより小さいことがある。</translation>
    </message>
    <message>
        <source>Template</source>
        <translation>型</translation>
    </message>
    <message>
        <source>sphere of %1 mm</source>
        <translation>%1 mm の球</translation>
    </message>
    <message>
        <source>No objection</source>
        <translation>問題なし</translation>
    </message>
    <message>
        <source>Caution</source>
        <translation>注意</translation>
    </message>
    <message>
        <source>Objection</source>
        <translation>不可</translation>
    </message>
    <message>
        <source>Not usable</source>
        <translation>使えません</translation>
    </message>
    <message>
        <source>Why</source>
        <translation>理由</translation>
    </message>
    <message>
        <source>Not planned yet: press Plan to cut, open and measure.</source>
        <translation>まだ計画していません。「計画」を押すと、切り、開き、測ります。</translation>
    </message>
    <message>
        <source>Waiting to be planned.</source>
        <translation>計画の順番を待っています。</translation>
    </message>
    <message>
        <source>Being planned.</source>
        <translation>計画しています。</translation>
    </message>
    <message>
        <source>Being cancelled.</source>
        <translation>中止しています。</translation>
    </message>
    <message>
        <source>Planning failed.</source>
        <translation>計画に失敗しました。</translation>
    </message>
    <message>
        <source>Score %1, lowered because little is seen, the highest, within the error</source>
        <translation>点数 %1（見える部分が少ないため減点、最高、誤差の範囲内）</translation>
    </message>
    <message>
        <source>Score %1, lowered because little is seen, the highest</source>
        <translation>点数 %1（見える部分が少ないため減点、最高）</translation>
    </message>
    <message>
        <source>Score %1, lowered because little is seen</source>
        <translation>点数 %1（見える部分が少ないため減点）</translation>
    </message>
    <message>
        <source>forces by hand may be off by two or three times: plan the approach first, and they are matched to its plan</source>
        <translation>手動操作の力は 2 〜 3 倍ずれることがあります。先にアプローチを計画すると、その計画に合わせて補正されます</translation>
    </message>
    <message>
        <source>Plan: %1 N (%2 to %3 N) at %4 mm, %5 % of the target seen; not matched: forces by hand may be off by two or three times</source>
        <translation>計画：%4 mm で %1 N（%2 〜 %3 N）、標的の %5 % が見える。補正なし：手動操作の力は 2 〜 3 倍ずれることがあります</translation>
    </message>
    <message>
        <source>Plan: %1 N (%2 to %3 N) at %4 mm, %5 % of the target seen; all forces by hand are scaled by one factor, so that they meet it there</source>
        <translation>計画：%4 mm で %1 N（%2 〜 %3 N）、標的の %5 % が見える。手による力はすべて、そこで計画と一致するよう同じ係数を掛けています</translation>
    </message>
    <message>
        <source>Score %1, the highest, within the error</source>
        <translation>点数 %1（最高、誤差の範囲内）</translation>
    </message>
    <message>
        <source>Score %1, the highest</source>
        <translation>点数 %1（最高）</translation>
    </message>
    <message>
        <source>Score %1</source>
        <translation>点数 %1</translation>
    </message>
    <message>
        <source>The score weighs: %1. Shift+W changes this.</source>
        <translation>点数の重み：%1。Shift+W で変えられます。</translation>
    </message>
    <message>
        <source>Green: better than every other by more than both errors together.</source>
        <translation>緑：両方の誤差の和を超えて、ほかのどれよりもよい。</translation>
    </message>
    <message>
        <source>Think of this first</source>
        <translation>先に考えること</translation>
    </message>
    <message>
        <source>Numbers of the field</source>
        <translation>術野の数値</translation>
    </message>
    <message>
        <source>Comparison</source>
        <translation>比較</translation>
    </message>
    <message>
        <source>The case has no approach yet. Press New for a standard approach, or Draw to draw an incision on the skin.</source>
        <translation>症例にはまだアプローチがありません。「新規」で標準的なアプローチを加えるか、「描く」で皮膚に切開を描いてください。</translation>
    </message>
    <message>
        <source>to</source>
        <translation>〜</translation>
    </message>
    <message>
        <source>Search for an incision</source>
        <translation>切開を探す</translation>
    </message>
    <message>
        <source>Search</source>
        <translation>探す</translation>
    </message>
    <message>
        <source>Add to the case</source>
        <translation>症例に加える</translation>
    </message>
    <message>
        <source>Back</source>
        <translation>戻る</translation>
    </message>
    <message>
        <source>Tries a thousand incisions by lines of sight, then cuts and opens the best as draft plans. This takes some minutes; the window can be used meanwhile.</source>
        <translation>千通りの切開を視線で調べ、よいものを下書きの計画として切り、開きます。数分かかりますが、その間もウィンドウを使えます。</translation>
    </message>
    <message>
        <source>Both sides</source>
        <translation>両側</translation>
    </message>
    <message>
        <source>Between the ribs</source>
        <translation>肋間</translation>
    </message>
    <message>
        <source>Spaces</source>
        <translation>肋間の範囲</translation>
    </message>
    <message>
        <source>Length of the incision</source>
        <translation>切開の長さ</translation>
    </message>
    <message>
        <source>The sternum may be sawn through</source>
        <translation>胸骨を切ってもよい</translation>
    </message>
    <message>
        <source>Place</source>
        <translation>位置</translation>
    </message>
    <message>
        <source>Score</source>
        <translation>点数</translation>
    </message>
    <message>
        <source>Seen</source>
        <translation>見える</translation>
    </message>
    <message>
        <source>Two instruments</source>
        <translation>二本の器械</translation>
    </message>
    <message>
        <source>Force</source>
        <translation>力</translation>
    </message>
    <message>
        <source>Draft plan says</source>
        <translation>下書きの計画</translation>
    </message>
    <message>
        <source>lines of sight</source>
        <translation>視線</translation>
    </message>
    <message>
        <source>Searching: %1</source>
        <translation>探しています：%1</translation>
    </message>
    <message>
        <source>%1 incisions were tried and %2 planned, in %3 s. The numbers are of draft plans, without error bars: plan what you add before you decide.</source>
        <translation>%1 通りの切開を調べ、%2 通りを計画しました（%3 秒）。数値は誤差の幅のない下書きの計画のものです。決める前に、加えたものを計画してください。</translation>
    </message>
    <message>
        <source>No proposal: %1</source>
        <translation>提案なし：%1</translation>
    </message>
    <message>
        <source>Does not fit: %1</source>
        <translation>合わない：%1</translation>
    </message>
    <message>
        <source>None of these incisions can be proposed.</source>
        <translation>提案できる切開はありませんでした。</translation>
    </message>
    <message>
        <source>skin</source>
        <translation>皮膚</translation>
    </message>
    <message>
        <source>Target here</source>
        <translation>ここを標的に</translation>
    </message>
    <message>
        <source>The slices meet in the %1. What is done here?</source>
        <translation>断面は%1で交わっています。ここで何をしますか</translation>
    </message>
    <message>
        <source>The slices meet beside the %1. What is done here?</source>
        <translation>断面は%1の横で交わっています。ここで何をしますか</translation>
    </message>
    <message>
        <source>The whole %1 is the target</source>
        <translation>%1全体を標的にする</translation>
    </message>
    <message>
        <source>The surface of the %1 up to this distance is the target.</source>
        <translation>この距離までの%1の表面が標的です。</translation>
    </message>
    <message>
        <source>Site</source>
        <translation>部位</translation>
    </message>
    <message>
        <source>Reaches</source>
        <translation>範囲</translation>
    </message>
    <message>
        <source>Take as target</source>
        <translation>標的にする</translation>
    </message>
    <message>
        <source>Weights of the score</source>
        <translation>点数の重み</translation>
    </message>
    <message>
        <source>How much each criterion counts in the score. 0 leaves it out.</source>
        <translation>各項目を点数でどれだけ重く見るか。0 なら数えない。</translation>
    </message>
    <message>
        <source>Defaults</source>
        <translation>標準に戻す</translation>
    </message>
    <message>
        <source>All weights are 0: nothing would count. The weights before stay.</source>
        <translation>重みがすべて 0 です。何も数えられないので、前の重みのままにします。</translation>
    </message>
    <message>
        <source>Choose this approach</source>
        <translation>このアプローチに決める</translation>
    </message>
    <message>
        <source>It is not planned.</source>
        <translation>計画されていません。</translation>
    </message>
    <message>
        <source>So far: %1</source>
        <translation>これまで：%1</translation>
    </message>
    <message>
        <source>person or team</source>
        <translation>人またはチーム</translation>
    </message>
    <message>
        <source>Chosen by</source>
        <translation>決めた人</translation>
    </message>
    <message>
        <source>Because</source>
        <translation>理由</translation>
    </message>
    <message>
        <source>Choose</source>
        <translation>決定</translation>
    </message>
    <message>
        <source>Six questions about the planned field</source>
        <translation>計画した術野についての六つの質問</translation>
    </message>
    <message>
        <source>person</source>
        <translation>人</translation>
    </message>
    <message>
        <source>Answered by</source>
        <translation>答えた人</translation>
    </message>
    <message>
        <source>1: I disagree … 5: I agree</source>
        <translation>1：そう思わない … 5：そう思う</translation>
    </message>
    <message>
        <source>a note, if you like</source>
        <translation>メモ（任意）</translation>
    </message>
    <message>
        <source>Keep the answers</source>
        <translation>回答を残す</translation>
    </message>
    <message>
        <source>Answers over cases</source>
        <translation>症例全体の回答</translation>
    </message>
    <message>
        <source>%1 cases. Of several answers of one person to one case the last one counts.</source>
        <translation>%1 症例。一人が同じ症例に何度か答えたときは、最後の回答を数えます。</translation>
    </message>
    <message>
        <source>%1 case. Of several answers of one person to one case the last one counts.</source>
        <translation>%1 症例。一人が同じ症例に何度か答えたときは、最後の回答を数えます。</translation>
    </message>
    <message>
        <source>Question</source>
        <translation>質問</translation>
    </message>
    <message>
        <source>Answers</source>
        <translation>回答数</translation>
    </message>
    <message>
        <source>Mean</source>
        <translation>平均</translation>
    </message>
    <message>
        <source>Range</source>
        <translation>範囲</translation>
    </message>
    <message>
        <source>Notes of the conference</source>
        <translation>カンファレンスのメモ</translation>
    </message>
    <message>
        <source>Notes for this step, kept with the case</source>
        <translation>この場面のメモ（症例とともに残る）</translation>
    </message>
    <message>
        <source>This is the last step.</source>
        <translation>最後の場面です。</translation>
    </message>
    <message>
        <source>Next: %1</source>
        <translation>次：%1</translation>
    </message>
    <message>
        <source>Picture</source>
        <translation>画像</translation>
    </message>
    <message>
        <source>Movie…</source>
        <translation>動画…</translation>
    </message>
    <message>
        <source>Save a movie of the plans (Ctrl+M)</source>
        <translation>計画の動画を保存する (Ctrl+M)</translation>
    </message>
    <message>
        <source>Report…</source>
        <translation>報告書…</translation>
    </message>
    <message>
        <source>Save the report (Ctrl+R)</source>
        <translation>報告書を保存する (Ctrl+R)</translation>
    </message>
    <message>
        <source>End</source>
        <translation>終わる</translation>
    </message>
    <message>
        <source>The step before (Left, Page Up)</source>
        <translation>前の場面（←、Page Up）</translation>
    </message>
    <message>
        <source>The next step (Right, Page Down, Space)</source>
        <translation>次の場面（→、Page Down、スペース）</translation>
    </message>
    <message>
        <source>The step before</source>
        <translation>前の場面</translation>
    </message>
    <message>
        <source>The next step</source>
        <translation>次の場面</translation>
    </message>
    <message>
        <source>Back to planning (Esc)</source>
        <translation>計画に戻る (Esc)</translation>
    </message>
    <message>
        <source>End the tour (Esc)</source>
        <translation>ツアーを終える (Esc)</translation>
    </message>
    <message>
        <source>Retractor: manual</source>
        <translation>Retractor：マニュアル</translation>
    </message>
    <message>
        <source>Target seen, best eye</source>
        <translation>標的の見える割合（最良の目）</translation>
    </message>
    <message>
        <source>Seen from the best place of the surgeon's eye, at less than 60 degrees of incidence; share of what an eye would see with the wall removed.</source>
        <translation>術者の目の最良の位置から、入射角 60 度未満で見える割合。胸壁がないときに見えるものに対する比。</translation>
    </message>
    <message>
        <source>... with two eyes and a lamp</source>
        <translation>… 両眼と照明で</translation>
    </message>
    <message>
        <source>Seen by both of two eyes 64 mm apart, with light from between them.</source>
        <translation>64 mm 離れた両眼に見え、その間からの光が届く割合。</translation>
    </message>
    <message>
        <source>... and reached by two instruments</source>
        <translation>… 二本の器械も届く</translation>
    </message>
    <message>
        <source>Seen, and within reach of two straight shafts of 8 mm at once, at least 15 degrees apart.</source>
        <translation>見えて、かつ 15 度以上離れた径 8 mm のまっすぐなシャフト二本が同時に届く割合。</translation>
    </message>
    <message>
        <source>Touched by a finger</source>
        <translation>指が届く</translation>
    </message>
    <message>
        <source>Within reach of a straight finger, 16 mm thick and 80 mm from the skin, seen or not.</source>
        <translation>太さ 16 mm、皮膚から 80 mm のまっすぐな指が届く割合（見えるかどうかによらない）。</translation>
    </message>
    <message>
        <source>Target in the picture</source>
        <translation>画像の中の標的</translation>
    </message>
    <message>
        <source>Share of the target's picture that the best eye sees: area as it appears, over that of the target alone.</source>
        <translation>最良の目に写る標的の面積を、標的だけのときの面積で割ったもの。</translation>
    </message>
    <message>
        <source>Target's area seen, mean eye</source>
        <translation>見える面積の割合（目の平均）</translation>
    </message>
    <message>
        <source>Share of the target's whole area that an eye of the cone sees, averaged over the cone.</source>
        <translation>視点の円錐の中の目に見える標的全面積の割合の平均。</translation>
    </message>
    <message>
        <source>... from the central eye alone</source>
        <translation>… 中央の目だけ</translation>
    </message>
    <message>
        <source>The same share, seen from the middle of the cone alone.</source>
        <translation>円錐の中央だけから見た同じ割合。</translation>
    </message>
    <message>
        <source>... from any eye of the cone (union)</source>
        <translation>… いずれかの目から（和）</translation>
    </message>
    <message>
        <source>Share of the target's whole area that at least one eye of the cone sees. No single eye sees all of it.</source>
        <translation>円錐の少なくとも一つの目に見える標的全面積の割合。一つの目にすべてが見えるわけではない。</translation>
    </message>
    <message>
        <source>... the same with the wall removed</source>
        <translation>… 胸壁がないとき</translation>
    </message>
    <message>
        <source>The union with no chest wall in the way: no retractor can show more.</source>
        <translation>胸壁に遮られないときの和。どの開創器もこれ以上は見せられない。</translation>
    </message>
    <message>
        <source>Opening area</source>
        <translation>開口の面積</translation>
    </message>
    <message>
        <source>Area between the opened lips.</source>
        <translation>開いた創縁の間の面積。</translation>
    </message>
    <message>
        <source>Opening width</source>
        <translation>開口の幅</translation>
    </message>
    <message>
        <source>Largest distance between the lips, across the incision.</source>
        <translation>切開に直交する創縁間の最大の距離。</translation>
    </message>
    <message>
        <source>Working distance</source>
        <translation>作業距離</translation>
    </message>
    <message>
        <source>Distance from the opening to the target.</source>
        <translation>開口から標的までの距離。</translation>
    </message>
    <message>
        <source>Access angle, horizontal</source>
        <translation>到達角（水平）</translation>
    </message>
    <message>
        <source>Direction from the target to the opening: in the axial plane, from straight ahead towards the patient's left.</source>
        <translation>標的から開口への向き。横断面で、正面から患者の左へ測る。</translation>
    </message>
    <message>
        <source>Access angle, vertical</source>
        <translation>到達角（上下）</translation>
    </message>
    <message>
        <source>Direction from the target to the opening: out of the axial plane, towards the head.</source>
        <translation>標的から開口への向き。横断面から頭側へ測る。</translation>
    </message>
    <message>
        <source>Best eye off the square view</source>
        <translation>最良の目の傾き</translation>
    </message>
    <message>
        <source>Angle between the best eye's line of sight and the normal of the opening's skin plane.</source>
        <translation>最良の目の視線と、開口の皮膚面の法線との角度。</translation>
    </message>
    <message>
        <source>Target off the middle</source>
        <translation>標的の中心からのずれ</translation>
    </message>
    <message>
        <source>Distance of the target from the line through the middle of the opening, square to the skin.</source>
        <translation>開口の中心を通り皮膚に垂直な線から標的までの距離。</translation>
    </message>
    <message>
        <source>Angle of attack along the cut</source>
        <translation>操作角（切開に沿う）</translation>
    </message>
    <message>
        <source>Angle at the target between the outermost straight lines to the lips of the skin, along the incision. What lies between does not count.</source>
        <translation>標的から皮膚の創縁への最も外側の直線がなす角度（切開に沿う）。間にあるものは数えない。</translation>
    </message>
    <message>
        <source>Angle of attack across the cut</source>
        <translation>操作角（切開に直交）</translation>
    </message>
    <message>
        <source>The same angle across the incision.</source>
        <translation>切開に直交する同じ角度。</translation>
    </message>
    <message>
        <source>Solid angle of the opening</source>
        <translation>開口の立体角</translation>
    </message>
    <message>
        <source>Solid angle that the opening of the skin fills, seen from the target; half of all directions are 6.3 sr.</source>
        <translation>標的から見て皮膚の開口が占める立体角。全方向の半分が 6.3 sr。</translation>
    </message>
    <message>
        <source>Surgical freedom</source>
        <translation>器械の自由度</translation>
    </message>
    <message>
        <source>Area over which the near end of a straight instrument of 300 mm and 8 mm can move, with its tip on the middle of what is seen, past wall, blades and organs.</source>
        <translation>長さ 300 mm、径 8 mm のまっすぐな器械の先を見える部分の中央に置き、胸壁、ブレード、臓器をよけて手元が動ける面積。</translation>
    </message>
    <message>
        <source>Incision length</source>
        <translation>切開の長さ</translation>
    </message>
    <message>
        <source>Length of the incision along the skin.</source>
        <translation>皮膚に沿う切開の長さ。</translation>
    </message>
    <message>
        <source>Depth of cut</source>
        <translation>切開の深さ</translation>
    </message>
    <message>
        <source>Depth of the cut along the blade.</source>
        <translation>刃に沿う切開の深さ。</translation>
    </message>
    <message>
        <source>Force, larger side</source>
        <translation>力（大きい側）</translation>
    </message>
    <message>
        <source>Sum over the hooks of the side that pulls harder, at the last turn of a slow opening where they are moved by a distance.</source>
        <translation>強く引く側の鉤の力の和。距離で動かす場合は、ゆっくり開いた最後の一回しでの値。</translation>
    </message>
    <message>
        <source>Tissue strain, 99th percentile</source>
        <translation>組織のひずみ（99 パーセンタイル）</translation>
    </message>
    <message>
        <source>Exceeded by one hundredth of the wall's volume, outside the patches and the cut front.</source>
        <translation>鉤の当たる所と切り口の先端を除き、胸壁の体積の百分の一が超える値。</translation>
    </message>
    <message>
        <source>Largest volume ratio</source>
        <translation>最大の体積比</translation>
    </message>
    <message>
        <source>Largest change of volume of an element.</source>
        <translation>要素の体積変化の最大。</translation>
    </message>
    <message>
        <source>Residual</source>
        <translation>残差</translation>
    </message>
    <message>
        <source>Relative residual force of the mechanical equilibrium.</source>
        <translation>力の釣り合いの相対残差。</translation>
    </message>
    <message>
        <source>%1 ±: estimated change of the number with a finer mesh.</source>
        <translation>%1 ±：メッシュを細かくしたときの数値の変化の推定。</translation>
    </message>
    <message>
        <source>The %1 is not seen.</source>
        <translation>%1は見えません。</translation>
    </message>
    <message>
        <source>Shows %1 % of what could be seen of the %2.</source>
        <translation>%2の見えうる部分の %1 % が見えます。</translation>
    </message>
    <message>
        <source>A lung that keeps %1 % of its volume instead of %2 % leaves only %3 % of the %4 in sight.</source>
        <translation>肺が体積の %2 % ではなく %1 % を保つと、%4は %3 % しか見えません。</translation>
    </message>
    <message>
        <source>Opens %1 mm.</source>
        <translation>%1 mm 開きます。</translation>
    </message>
    <message>
        <source>Opens %1 mm wide.</source>
        <translation>幅 %1 mm 開きます。</translation>
    </message>
    <message>
        <source>Peak %1 to %2 N, held %3 N after %4.</source>
        <translation>最大 %1 〜 %2 N、%4後の保持力 %3 N。</translation>
    </message>
    <message>
        <source>Peak %1 N, held %2 N after %3.</source>
        <translation>最大 %1 N、%3後の保持力 %2 N。</translation>
    </message>
    <message>
        <source>Force %1 to %2 N.</source>
        <translation>力 %1 〜 %2 N。</translation>
    </message>
    <message>
        <source>Peak %1 to %2 N.</source>
        <translation>最大 %1 〜 %2 N。</translation>
    </message>
    <message>
        <source>Force %1 N.</source>
        <translation>力 %1 N。</translation>
    </message>
    <message>
        <source>Peak %1 N.</source>
        <translation>最大 %1 N。</translation>
    </message>
    <message>
        <source>%1 would break from %2 mm on.</source>
        <translation>%1は %2 mm から折れる見込みです。</translation>
    </message>
    <message>
        <source>%1 comes near breaking.</source>
        <translation>%1は折れそうです。</translation>
    </message>
    <message>
        <source>Whether a bone would break is not known.</source>
        <translation>骨が折れるかどうかはわかりません。</translation>
    </message>
    <message>
        <source>%1 would tear.</source>
        <translation>%1は裂ける見込みです。</translation>
    </message>
    <message>
        <source>%1 may tear.</source>
        <translation>%1は裂けることがあります。</translation>
    </message>
    <message>
        <source>The %1 would tear.</source>
        <translation>%1は裂ける見込みです。</translation>
    </message>
    <message>
        <source>The %1 may tear.</source>
        <translation>%1は裂けることがあります。</translation>
    </message>
    <message>
        <source>Rib spreaders ruptured tissue in half of 24 pigs (17 of them carcasses), always beyond 30 mm and 122.5 N.</source>
        <translation>肋骨開創器では 24 頭のブタ（うち 17 頭は屠体）の半数で組織が断裂し、いずれも 30 mm と 122.5 N を超えていました。</translation>
    </message>
    <message>
        <source>Bone comes through the skin, which the model does not hinder.</source>
        <translation>骨が皮膚を突き抜けています。モデルはこれを妨げません。</translation>
    </message>
    <message>
        <source>Tissue still moves where the model ends: the force is less certain.</source>
        <translation>モデルの端で組織がまだ動いています。力は不確かです。</translation>
    </message>
    <message>
        <source>The cut comes within 2 mm of the %1.</source>
        <translation>切開は%1から2 mm以内に達します。</translation>
    </message>
    <message>
        <source>The blade cuts the %1.</source>
        <translation>刃が%1を切ります。</translation>
    </message>
    <message>
        <source>The %1 lies against the %2.</source>
        <translation>%1が%2に接しています。</translation>
    </message>
    <message>
        <source>The %1 is only estimated.</source>
        <translation>%1は推定にすぎません。</translation>
    </message>
    <message>
        <source>The wound could not be computed: do not use these numbers.</source>
        <translation>創を計算できませんでした。この数値を使わないでください。</translation>
    </message>
    <message>
        <source>The model fails near the wound: do not use these numbers.</source>
        <translation>創の近くでモデルが破綻しています。この数値を使わないでください。</translation>
    </message>
    <message>
        <source>No retractor pulls with %1 N: do not use these numbers. Check what the hooks hold.</source>
        <translation>%1 N で引く開創器はありません。この数値を使わないでください。鉤が何をつかんでいるか確かめてください。</translation>
    </message>
    <message>
        <source>The case holds numbers that no patient has: do not use the result.</source>
        <translation>症例に、患者にありえない数値があります。この結果を使わないでください。</translation>
    </message>
    <message>
        <source>target seen</source>
        <translation>標的が見える</translation>
    </message>
    <message>
        <source>share of the target that the best eye sees, 0 to 100 %; below 25 % the whole score falls with it</source>
        <translation>最良の目に見える標的の割合、0 〜 100 %。25 % 未満では点数全体がそれに応じて下がる</translation>
    </message>
    <message>
        <source>reached by instruments</source>
        <translation>器械が届く</translation>
    </message>
    <message>
        <source>share that is seen and reached by two instruments, 0 to 100 %</source>
        <translation>見えて二本の器械が届く割合、0 〜 100 %</translation>
    </message>
    <message>
        <source>straight view</source>
        <translation>正面の視野</translation>
    </message>
    <message>
        <source>angle between the best line of sight and the straight view into the opening, 60 to 0 degrees</source>
        <translation>最良の視線と開口の正面との角度、60 〜 0 度</translation>
    </message>
    <message>
        <source>short incision</source>
        <translation>短い切開</translation>
    </message>
    <message>
        <source>length of the incision, 300 to 30 mm</source>
        <translation>切開の長さ、300 〜 30 mm</translation>
    </message>
    <message>
        <source>bone spared</source>
        <translation>骨の温存</translation>
    </message>
    <message>
        <source>a bone that is sawn through, removed or breaks counts 1, else the largest share of what a bone bears: 1 to 0</source>
        <translation>切る、取り除く、または折れる骨は 1、ほかは骨が耐える力に対する最大の割合：1 〜 0</translation>
    </message>
    <message>
        <source>structures far</source>
        <translation>構造から遠い</translation>
    </message>
    <message>
        <source>distance of the nearest structure at risk from the blades, 0 to 20 mm</source>
        <translation>最も近い損傷してはならない構造とブレードの距離、0 〜 20 mm</translation>
    </message>
    <message>
        <source>low force</source>
        <translation>小さな力</translation>
    </message>
    <message>
        <source>force at the last turn, from twice the smallest force at which tissue ruptured (122.5 N) to 0</source>
        <translation>最後の一回しの力。組織が断裂した最小の力 (122.5 N) の二倍から 0 まで</translation>
    </message>
    <message>
        <source>The %1 may be cut.</source>
        <translation>%1が切れるおそれがあります。</translation>
    </message>
    <message>
        <source>The blade may cut the %1.</source>
        <translation>刃が%1を切るおそれがあります。</translation>
    </message>
    <message>
        <source>The %1 is cut.</source>
        <translation>%1が切れます。</translation>
    </message>
    <message>
        <source>The %1 lies %2 mm from the %3.</source>
        <translation>%1は%3から %2 mm にあります。</translation>
    </message>
    <message>
        <source>blade that cuts</source>
        <translation>切る刃</translation>
    </message>
    <message>
        <source>%1 is sawn through.</source>
        <translation>%1を鋸で切断します。</translation>
    </message>
    <message>
        <source>%1 is removed in part.</source>
        <translation>%1の一部を取り除きます。</translation>
    </message>
    <message>
        <source>Held aside for this view: %1.</source>
        <translation>この視野のために圧排するもの：%1。</translation>
    </message>
    <message>
        <source>Nothing found.</source>
        <translation>見つかりませんでした。</translation>
    </message>
    <message>
        <source>the organs %1 mm nearer to the head</source>
        <translation>臓器が %1 mm 頭側に寄った場合</translation>
    </message>
    <message>
        <source>lungs of %1 % of their volume</source>
        <translation>肺が体積の %1 % の場合</translation>
    </message>
    <message>
        <source>%1 shows most also when patient, organs or lungs lie otherwise: from %2 to %3.</source>
        <translation>患者の体位や、臓器・肺の位置が変わっても %1 が最もよく見えます：%2 〜 %3。</translation>
    </message>
    <message>
        <source>Finite elements</source>
        <translation>有限要素</translation>
    </message>
    <message>
        <source>Springs</source>
        <translation>ばね</translation>
    </message>
    <message>
        <source>Spheres</source>
        <translation>球</translation>
    </message>
    <message>
        <source>Fingers</source>
        <translation>指</translation>
    </message>
    <message>
        <source>Forces at the hand</source>
        <translation>手に返る力</translation>
    </message>
    <message>
        <source>computed %1 times a second; %2 of %3 were skipped</source>
        <translation>毎秒 %1 回計算、%3 回中 %2 回を省略</translation>
    </message>
    <message>
        <source>The computer gives them no priority.</source>
        <translation>コンピュータはこの計算を優先していません。</translation>
    </message>
    <message>
        <source>A Touch reported a problem.</source>
        <translation>Touch が問題を報告しました。</translation>
    </message>
    <message>
        <source>A force takes %1 µs on average, and took %2 µs at most.</source>
        <translation>1 回の計算は平均 %1 µs、最長 %2 µs です。</translation>
    </message>
    <message>
        <source>Tissue</source>
        <translation>組織</translation>
    </message>
    <message>
        <source>Change elasticity with a template</source>
        <translation>型で硬さを変える</translation>
    </message>
    <message>
        <source>Show</source>
        <translation>表示</translation>
    </message>
    <message>
        <source>Record</source>
        <translation>記録</translation>
    </message>
    <message>
        <source>Record the motion and the force of every finger at 1 kHz, for five minutes at most (R)</source>
        <translation>すべての指の動きと力を 1 kHz で、最長五分記録する (R)</translation>
    </message>
    <message>
        <source>Reset</source>
        <translation>元に戻す</translation>
    </message>
    <message>
        <source>Restore the elasticity, the heart rate and the fingers of the scene</source>
        <translation>場面の硬さ、心拍数、指を元に戻す</translation>
    </message>
    <message>
        <source>Device that moves this finger: the mouse, a simulated hand, a Touch (touch, touch:NAME, touch:#SERIAL), a device on another computer (udp:PORT) or a recording (replay:FILE)</source>
        <translation>この指を動かす装置：マウス、模擬の手、Touch (touch, touch:名前, touch:#番号)、別の計算機の装置 (udp:ポート)、記録 (replay:ファイル)</translation>
    </message>
    <message>
        <source>Depth to which the left button presses a fingertip. The wheel changes the depth while the button is held</source>
        <translation>左ボタンで指先を押し込む深さ。ボタンを押したままホイールを回すと深さが変わる</translation>
    </message>
    <message>
        <source>Press</source>
        <translation>押す</translation>
    </message>
    <message>
        <source>Grip</source>
        <translation>つかむ</translation>
    </message>
    <message>
        <source>The selected finger grips the tissue under it and pulls the tissue along (G)</source>
        <translation>選んだ指が下の組織をつかみ、引いて動かす (G)</translation>
    </message>
    <message>
        <source>Lift all</source>
        <translation>すべて離す</translation>
    </message>
    <message>
        <source>All fingers leave the tissue (Esc)</source>
        <translation>すべての指を組織から離す (Esc)</translation>
    </message>
    <message>
        <source>Arm again</source>
        <translation>力を再び入れる</translation>
    </message>
    <message>
        <source>Switch the forces on again; they return within half a second</source>
        <translation>力を再び入れる。半秒以内に戻る</translation>
    </message>
    <message>
        <source>Model</source>
        <translation>モデル</translation>
    </message>
    <message>
        <source>Heart rate</source>
        <translation>心拍数</translation>
    </message>
    <message>
        <source>Force gain</source>
        <translation>力の倍率</translation>
    </message>
    <message>
        <source>Factor for the forces that the hands feel. The numbers show the forces of the tissue without this factor</source>
        <translation>手が感じる力にかける倍率。数値は倍率をかけない組織の力を示す</translation>
    </message>
    <message>
        <source>Sphere</source>
        <translation>球</translation>
    </message>
    <message>
        <source>Box</source>
        <translation>直方体</translation>
    </message>
    <message>
        <source>Shape</source>
        <translation>形</translation>
    </message>
    <message>
        <source>Radius of the sphere, or half of each edge of the box (along x, y, z), in mm</source>
        <translation>球の半径、または直方体の各辺の半分（x、y、z、単位 mm）</translation>
    </message>
    <message>
        <source>Size, mm</source>
        <translation>大きさ、mm</translation>
    </message>
    <message>
        <source>A value that is not ticked stays unchanged</source>
        <translation>印のない値は変わらない</translation>
    </message>
    <message>
        <source>Young's modulus</source>
        <translation>ヤング率</translation>
    </message>
    <message>
        <source>Poisson's ratio</source>
        <translation>ポアソン比</translation>
    </message>
    <message>
        <source>Whether the tissue inside the template is held or free to move</source>
        <translation>型の中の組織を固定するか、動けるようにするか</translation>
    </message>
    <message>
        <source>unchanged</source>
        <translation>そのまま</translation>
    </message>
    <message>
        <source>held</source>
        <translation>固定</translation>
    </message>
    <message>
        <source>free</source>
        <translation>自由</translation>
    </message>
    <message>
        <source>Tissue inside</source>
        <translation>中の組織</translation>
    </message>
    <message>
        <source>Then click on the tissue to place the centre of the template (T)</source>
        <translation>次に組織をクリックして型の中心を置く (T)</translation>
    </message>
    <message>
        <source>Apply</source>
        <translation>適用</translation>
    </message>
    <message>
        <source>Give these values to the tissue inside the template. The fingers feel the change within moments</source>
        <translation>型の中の組織にこの値を与える。指はすぐに変化を感じる</translation>
    </message>
    <message>
        <source>Hand</source>
        <translation>手</translation>
    </message>
    <message>
        <source>Show a hand on the fingertips (H)</source>
        <translation>指先に手を表示する (H)</translation>
    </message>
    <message>
        <source>Spheres inside</source>
        <translation>中の球</translation>
    </message>
    <message>
        <source>Show the spheres that fill the organs. The spheres that a finger moves are bright (S)</source>
        <translation>臓器を満たす球を表示する。指が動かす球は明るい (S)</translation>
    </message>
    <message>
        <source>Selected finger</source>
        <translation>選んだ指</translation>
    </message>
    <message>
        <source>Left button: press the fingertip in   ·   drag: slide along   ·   wheel while pressing: press deeper or less   ·   keys 1, 2, …: select another finger, this finger stays   ·   Esc: lift all   ·   right button: turn the camera</source>
        <translation>左ボタン：指先を押し込む   ·   ドラッグ：すべらせる   ·   押しながらホイール：深さを変える   ·   1、2、…：別の指を選ぶ（この指は残る）   ·   Esc：すべて離す   ·   右ボタン：視点を回す</translation>
    </message>
    <message>
        <source>Open a palpation scene to begin: File, Open scene</source>
        <translation>触診の場面を開いて始めます：ファイル、場面を開く</translation>
    </message>
    <message>
        <source>Preparing the tissue again …</source>
        <translation>組織を準備し直しています…</translation>
    </message>
    <message>
        <source>Preparing the tissue …</source>
        <translation>組織を準備しています…</translation>
    </message>
    <message>
        <source>Preparing the tissue</source>
        <translation>組織を準備しています</translation>
    </message>
    <message>
        <source>F&amp;ingers</source>
        <translation>指(&amp;I)</translation>
    </message>
    <message>
        <source>&amp;Show</source>
        <translation>表示(&amp;S)</translation>
    </message>
    <message>
        <source>Open scene…</source>
        <translation>場面を開く…</translation>
    </message>
    <message>
        <source>Record or stop</source>
        <translation>記録または停止</translation>
    </message>
    <message>
        <source>Select finger %1</source>
        <translation>指 %1 を選ぶ</translation>
    </message>
    <message>
        <source>Hand from a file…</source>
        <translation>ファイルの手…</translation>
    </message>
    <message>
        <source>Place the template</source>
        <translation>型を置く</translation>
    </message>
    <message>
        <source>Show the whole scene</source>
        <translation>場面全体を見せる</translation>
    </message>
    <message>
        <source>Retractor - palpation</source>
        <translation>Retractor - 触診</translation>
    </message>
    <message>
        <source>Retractor - palpation of %1</source>
        <translation>Retractor - %1の触診</translation>
    </message>
    <message>
        <source>Click on the tissue to place the centre of the template</source>
        <translation>組織をクリックして型の中心を置いてください</translation>
    </message>
    <message>
        <source>Save the recording</source>
        <translation>記録を保存</translation>
    </message>
    <message>
        <source>Motion (*.motion);;Motion as CSV (*.csv)</source>
        <translation>動き (*.motion);;動きの CSV (*.csv)</translation>
    </message>
    <message>
        <source>Open palpation scene</source>
        <translation>触診の場面を開く</translation>
    </message>
    <message>
        <source>Palpation scene (*.json)</source>
        <translation>触診の場面 (*.json)</translation>
    </message>
    <message>
        <source>Pressure and force over time</source>
        <translation>圧と力の時間変化</translation>
    </message>
    <message>
        <source>Blood pressure, mmHg</source>
        <translation>血圧、mmHg</translation>
    </message>
    <message>
        <source>Force on each finger, N</source>
        <translation>各指の力、N</translation>
    </message>
    <message>
        <source>now</source>
        <translation>今</translation>
    </message>
    <message>
        <source>%1 s ago</source>
        <translation>%1 秒前</translation>
    </message>
    <message>
        <source>there is no tissue under the mouse</source>
        <translation>マウスの下に組織がありません</translation>
    </message>
    <message>
        <source>The forces were switched off: %1</source>
        <translation>力が切れました：%1</translation>
    </message>
    <message>
        <source>Computing the new stiffness …</source>
        <translation>新しい剛性を計算しています…</translation>
    </message>
    <message>
        <source>%1 edit in force</source>
        <translation>有効な変更 %1 件</translation>
    </message>
    <message>
        <source>%1 edits in force</source>
        <translation>有効な変更 %1 件</translation>
    </message>
    <message>
        <source>Stop (%1 s)</source>
        <translation>停止（%1 秒）</translation>
    </message>
    <message>
        <source>approach median</source>
        <translation>アプローチ median</translation>
    </message>
    <message>
        <source>aorta</source>
        <translation>大動脈</translation>
    </message>
    <message>
        <source>aneurysm</source>
        <translation>動脈瘤</translation>
    </message>
    <message>
        <source>heart</source>
        <translation>心臓</translation>
    </message>
    <message>
        <source>trachea</source>
        <translation>気管</translation>
    </message>
    <message>
        <source>sternum</source>
        <translation>胸骨</translation>
    </message>
    <message>
        <source>pericardium</source>
        <translation>心膜</translation>
    </message>
    <message>
        <source>left lung</source>
        <translation>左肺</translation>
    </message>
    <message>
        <source>right lung</source>
        <translation>右肺</translation>
    </message>
    <message>
        <source>pulmonary trunk</source>
        <translation>肺動脈幹</translation>
    </message>
    <message>
        <source>superior vena cava</source>
        <translation>上大静脈</translation>
    </message>
    <message>
        <source>inferior vena cava</source>
        <translation>下大静脈</translation>
    </message>
    <message>
        <source>left atrium</source>
        <translation>左心房</translation>
    </message>
    <message>
        <source>left ventricle</source>
        <translation>左心室</translation>
    </message>
    <message>
        <source>muscle</source>
        <translation>筋</translation>
    </message>
    <message>
        <source>fat</source>
        <translation>脂肪</translation>
    </message>
    <message>
        <source>cartilage</source>
        <translation>軟骨</translation>
    </message>
    <message>
        <source>diaphragm</source>
        <translation>横隔膜</translation>
    </message>
    <message>
        <source>liver</source>
        <translation>肝臓</translation>
    </message>
    <message>
        <source>oesophagus</source>
        <translation>食道</translation>
    </message>
    <message>
        <source>spine</source>
        <translation>脊椎</translation>
    </message>
    <message>
        <source>left rib %1</source>
        <translation>左第 %1 肋骨</translation>
    </message>
    <message>
        <source>right rib %1</source>
        <translation>右第 %1 肋骨</translation>
    </message>
    <message>
        <source>Left rib %1</source>
        <translation>左第 %1 肋骨</translation>
    </message>
    <message>
        <source>Right rib %1</source>
        <translation>右第 %1 肋骨</translation>
    </message>
    <message>
        <source>Skin</source>
        <translation>皮膚</translation>
    </message>
    <message>
        <source>Sternum</source>
        <translation>胸骨</translation>
    </message>
    <message>
        <source>yes</source>
        <translation>はい</translation>
    </message>
    <message>
        <source>no</source>
        <translation>いいえ</translation>
    </message>
    <message>
        <source>saving: %1</source>
        <translation>保存中：%1</translation>
    </message>
    <message>
        <source>; chosen by %1</source>
        <translation>、決定：%1</translation>
    </message>
    <message>
        <source> per minute</source>
        <translation> /分</translation>
    </message>
    <message>
        <source> times</source>
        <translation> 倍</translation>
    </message>
    <message>
        <source>3D shape</source>
        <translation>立体形状</translation>
    </message>
    <message>
        <source>The three-dimensional shapes of the organs are clear.</source>
        <translation>臓器の立体的な形がよくわかる。</translation>
    </message>
    <message>
        <source>Location</source>
        <translation>位置関係</translation>
    </message>
    <message>
        <source>The positions of the organs and the target in the surgical field are clear.</source>
        <translation>術野の中の臓器と標的の位置がよくわかる。</translation>
    </message>
    <message>
        <source>Quality of the field</source>
        <translation>術野の質</translation>
    </message>
    <message>
        <source>The simulated surgical field looks as it will in the theatre.</source>
        <translation>模擬した術野は手術室での術野に見える。</translation>
    </message>
    <message>
        <source>Planning effect</source>
        <translation>計画への効果</translation>
    </message>
    <message>
        <source>Planning with it changes or confirms the approach.</source>
        <translation>これによる計画でアプローチが変わる、または確かになる。</translation>
    </message>
    <message>
        <source>Crisis recognition</source>
        <translation>危険の認識</translation>
    </message>
    <message>
        <source>It shows in advance what may go wrong.</source>
        <translation>起こりうる問題を前もって示す。</translation>
    </message>
    <message>
        <source>Necessity</source>
        <translation>必要性</translation>
    </message>
    <message>
        <source>Such planning is needed before operations like this one.</source>
        <translation>このような手術の前にはこのような計画が必要である。</translation>
    </message>
    <message>
        <source>anastomosis site</source>
        <translation>吻合部</translation>
    </message>
    <message>
        <source>clamp site</source>
        <translation>遮断部</translation>
    </message>
    <message>
        <source>proximal neck</source>
        <translation>中枢側ネック</translation>
    </message>
    <message>
        <source>distal neck</source>
        <translation>末梢側ネック</translation>
    </message>
    <message>
        <source>annulus</source>
        <translation>弁輪</translation>
    </message>
    <message>
        <source>Anastomosis site</source>
        <translation>吻合部</translation>
    </message>
    <message>
        <source>Clamp site</source>
        <translation>遮断部</translation>
    </message>
    <message>
        <source>Proximal neck</source>
        <translation>中枢側ネック</translation>
    </message>
    <message>
        <source>Distal neck</source>
        <translation>末梢側ネック</translation>
    </message>
    <message>
        <source>Annulus</source>
        <translation>弁輪</translation>
    </message>
    <message>
        <source>anastomosis site on %1</source>
        <translation>%1の吻合部</translation>
    </message>
    <message>
        <source>clamp site on %1</source>
        <translation>%1の遮断部</translation>
    </message>
    <message>
        <source>proximal neck on %1</source>
        <translation>%1の中枢側ネック</translation>
    </message>
    <message>
        <source>distal neck on %1</source>
        <translation>%1の末梢側ネック</translation>
    </message>
    <message>
        <source>annulus on %1</source>
        <translation>%1の弁輪</translation>
    </message>
    <message>
        <source>Finochietto rib spreader: %1</source>
        <translation>フィノチェット開胸器：%1</translation>
    </message>
    <message>
        <source>Sternal spreader: %1</source>
        <translation>胸骨開創器：%1</translation>
    </message>
    <message>
        <source>MIDCAB retractor: %1</source>
        <translation>MIDCAB 用開創器：%1</translation>
    </message>
    <message>
        <source>two broad blades on a rack, each turns about its arm</source>
        <translation>ラックに幅広のブレード二枚、それぞれがアームのまわりに回る</translation>
    </message>
    <message>
        <source>two long blades, almost fixed to their arms</source>
        <translation>長いブレード二枚、アームにほぼ固定</translation>
    </message>
    <message>
        <source>two small blades, for small incisions and the mitral valve</source>
        <translation>小さなブレード二枚、小切開と僧帽弁用</translation>
    </message>
    <message>
        <source>Finochietto rib spreader</source>
        <translation>フィノチェット開胸器</translation>
    </message>
    <message>
        <source>sternal spreader</source>
        <translation>胸骨開創器</translation>
    </message>
    <message>
        <source>Sternal spreader</source>
        <translation>胸骨開創器</translation>
    </message>
    <message>
        <source>MIDCAB retractor</source>
        <translation>MIDCAB 用開創器</translation>
    </message>
    <message>
        <source>no hooks</source>
        <translation>鉤なし</translation>
    </message>
    <message>
        <source>Thoracotomy, %1 space</source>
        <translation>開胸、%1肋間</translation>
    </message>
    <message>
        <source>Left thoracotomy, %1 space</source>
        <translation>左開胸、%1肋間</translation>
    </message>
    <message>
        <source>Right thoracotomy, %1 space</source>
        <translation>右開胸、%1肋間</translation>
    </message>
    <message>
        <source>J hemisternotomy</source>
        <translation>J 字胸骨部分切開</translation>
    </message>
    <message>
        <source>J hemisternotomy, %1 space</source>
        <translation>J 字胸骨部分切開、%1肋間</translation>
    </message>
    <message>
        <source>Left J hemisternotomy</source>
        <translation>左 J 字胸骨部分切開</translation>
    </message>
    <message>
        <source>Left J hemisternotomy, %1 space</source>
        <translation>左 J 字胸骨部分切開、%1肋間</translation>
    </message>
    <message>
        <source>T hemisternotomy</source>
        <translation>T 字胸骨部分切開</translation>
    </message>
    <message>
        <source>T hemisternotomy, %1 space</source>
        <translation>T 字胸骨部分切開、%1肋間</translation>
    </message>
    <message>
        <source>Left posterolateral thoracotomy, %1 space</source>
        <translation>左後側方開胸、%1肋間</translation>
    </message>
    <message>
        <source>Left anterior mini-thoracotomy</source>
        <translation>左前方小開胸</translation>
    </message>
    <message>
        <source>Left anterior mini-thoracotomy, %1 space</source>
        <translation>左前方小開胸、%1肋間</translation>
    </message>
    <message>
        <source>Right anterior mini-thoracotomy</source>
        <translation>右前方小開胸</translation>
    </message>
    <message>
        <source>Right anterior mini-thoracotomy, %1 space</source>
        <translation>右前方小開胸、%1肋間</translation>
    </message>
    <message>
        <source>Right lateral mini-thoracotomy</source>
        <translation>右側方小開胸</translation>
    </message>
    <message>
        <source>Right lateral mini-thoracotomy, %1 space</source>
        <translation>右側方小開胸、%1肋間</translation>
    </message>
    <message>
        <source>Drawn incision</source>
        <translation>描いた切開</translation>
    </message>
    <message>
        <source>1st</source>
        <translation>第 1 </translation>
    </message>
    <message>
        <source>2nd</source>
        <translation>第 2 </translation>
    </message>
    <message>
        <source>3rd</source>
        <translation>第 3 </translation>
    </message>
    <message>
        <source>4th</source>
        <translation>第 4 </translation>
    </message>
    <message>
        <source>5th</source>
        <translation>第 5 </translation>
    </message>
    <message>
        <source>6th</source>
        <translation>第 6 </translation>
    </message>
    <message>
        <source>7th</source>
        <translation>第 7 </translation>
    </message>
    <message>
        <source>8th</source>
        <translation>第 8 </translation>
    </message>
    <message>
        <source>9th</source>
        <translation>第 9 </translation>
    </message>
    <message>
        <source>10th</source>
        <translation>第 10 </translation>
    </message>
    <message>
        <source>The incision is %1 mm long.</source>
        <translation>切開の長さは %1 mm です。</translation>
    </message>
    <message>
        <source>The target: %1.</source>
        <translation>標的：%1。</translation>
    </message>
    <message>
        <source>The blade goes %1 mm deep.</source>
        <translation>刃の深さは %1 mm です。</translation>
    </message>
    <message>
        <source>Sawn through: %1.</source>
        <translation>鋸で切断する骨：%1。</translation>
    </message>
    <message>
        <source>Division: %1.</source>
        <translation>切離：%1。</translation>
    </message>
    <message>
        <source>Intercostal muscle and pleura are to be divided beyond the skin.</source>
        <translation>肋間筋と胸膜を皮膚切開より先まで切離します。</translation>
    </message>
    <message>
        <source>The sternum is to be sawn across under the skin.</source>
        <translation>皮下で胸骨を横断します。</translation>
    </message>
    <message>
        <source>Most is hidden by %1 (%2).</source>
        <translation>最も多くを隠すのは%1（%2）です。</translation>
    </message>
    <message>
        <source>Estimated, not seen in the image: %1 and others.</source>
        <translation>画像に見えず推定したもの：%1ほか。</translation>
    </message>
    <message>
        <source>Estimated, not seen in the image: %1.</source>
        <translation>画像に見えず推定したもの：%1。</translation>
    </message>
    <message>
        <source>%1: what the blade passes</source>
        <translation>%1：刃の通り道</translation>
    </message>
    <message>
        <source>%1: what is cut</source>
        <translation>%1：切離する部分</translation>
    </message>
    <message>
        <source>The red sheet is the cut.</source>
        <translation>赤い面が切離面です。</translation>
    </message>
    <message>
        <source>Side by side, two to four:</source>
        <translation>並べて比較（2～4）：</translation>
    </message>
    <message>
        <source>%1: opened</source>
        <translation>%1：開創</translation>
    </message>
    <message>
        <source>%1: what the surgeon sees</source>
        <translation>%1：術者に見えるもの</translation>
    </message>
    <message>
        <source>%1: what the surgeon reaches</source>
        <translation>%1：術者の手が届く所</translation>
    </message>
    <message>
        <source>No approach leads in what is seen by more than the error.</source>
        <translation>見える割合で、誤差を超えてまさるアプローチはありません。</translation>
    </message>
    <message>
        <source>The target is seen best through %1 (%2).</source>
        <translation>標的が最もよく見えるのは%1（%2）です。</translation>
    </message>
    <message>
        <source>Nothing is chosen yet.</source>
        <translation>まだ決めていません。</translation>
    </message>
    <message>
        <source>Not shown here: %1.</source>
        <translation>ここに示していないもの：%1。</translation>
    </message>
    <message>
        <source>%1: No objection.</source>
        <translation>%1：問題なし。</translation>
    </message>
    <message>
        <source>%1: Caution.</source>
        <translation>%1：注意。</translation>
    </message>
    <message>
        <source>%1: Objection.</source>
        <translation>%1：不可。</translation>
    </message>
    <message>
        <source>%1: Not usable.</source>
        <translation>%1：使えません。</translation>
    </message>
    <message>
        <source>The picture is not that of this step.</source>
        <translation>この画像はこの場面のものではありません。</translation>
    </message>
    <message>
        <source>Two to four stand side by side.</source>
        <translation>並べるのは 2～4 です。</translation>
    </message>
    <message>
        <source>A lung that keeps %1 % of its volume instead of %2 % leaves nothing of the %3 in sight.</source>
        <translation>肺が体積の %2 % ではなく %1 % を保つと、%3はまったく見えません。</translation>
    </message>
    <message>
        <source>There is no approach yet.</source>
        <translation>まだアプローチがありません。</translation>
    </message>
    <message>
        <source>there is no wound to open: cut first</source>
        <translation>開く創がありません。先に切ってください</translation>
    </message>
    <message>
        <source>there is no wound within 20 mm of here: press on the skin beside its edge</source>
        <translation>ここから 20 mm 以内に創がありません。創縁のそばの皮膚を押してください</translation>
    </message>
    <message>
        <source>the wound has just changed: press again</source>
        <translation>創が変わったばかりです。もう一度押してください</translation>
    </message>
    <message>
        <source>the wound has no other lip opposite: a retractor needs two</source>
        <translation>反対側に創縁がありません。開創器には二つの創縁が必要です</translation>
    </message>
    <message>
        <source>the edge of the wound has no direction here: press elsewhere on it</source>
        <translation>ここでは創縁の向きが決まりません。創縁の別の所を押してください</translation>
    </message>
    <message>
        <source>the edge of the wound gives no hold here: press elsewhere on it</source>
        <translation>ここの創縁は鉤を受けられません。創縁の別の所を押してください</translation>
    </message>
    <message>
        <source>the wound is too small here: fewer than three of its places are free to be held</source>
        <translation>ここでは創が小さすぎて、鉤をかけられません</translation>
    </message>
    <message>
        <source>the blade would reach beyond the end of the wound: press nearer to its middle</source>
        <translation>ブレードが創の端からはみ出します。もっと中央を押してください</translation>
    </message>
    <message>
        <source>the lips do not face each other here: press elsewhere on the edge</source>
        <translation>ここでは創縁が向かい合っていません。創縁の別の所を押してください</translation>
    </message>
    <message>
        <source>the knife is in a wound: begin on the skin</source>
        <translation>メスが創の中にあります。皮膚の上から始めてください</translation>
    </message>
    <message>
        <source>%1 is exposed here: the knife does not cut it</source>
        <translation>ここでは%1が露出しています。メスでは切りません</translation>
    </message>
    <message>
        <source>the wall has no inner side here: set a depth</source>
        <translation>ここでは体壁の内側がありません。深さを決めてください</translation>
    </message>
    <message>
        <source>the line left the region that can be cut</source>
        <translation>線が切れる範囲の外に出ました</translation>
    </message>
    <message>
        <source>the line jumps: draw on the skin</source>
        <translation>線が飛びました。皮膚の上に描いてください</translation>
    </message>
    <message>
        <source>the line left the wall</source>
        <translation>線が体壁から外れました</translation>
    </message>
    <message>
        <source>the knife did not move: draw a line on the skin</source>
        <translation>メスが動きませんでした。皮膚の上に線を描いてください</translation>
    </message>
    <message>
        <source>nothing was cut: %1</source>
        <translation>何も切れませんでした：%1</translation>
    </message>
    <message>
        <source>cut over %1 mm; a part of the line was not cut: %2</source>
        <translation>%1 mm 切りました。線の一部は切れませんでした：%2</translation>
    </message>
    <message>
        <source>a stroke is open: finish it first</source>
        <translation>描きかけの線があります。先に終えてください</translation>
    </message>
    <message>
        <source>the wall is cut already: undo the cuts, then cut as planned</source>
        <translation>体壁はすでに切られています。切開を取り消してから計画どおり切ってください</translation>
    </message>
    <message>
        <source>what is divided beyond the skin ends where the meshed wall does</source>
        <translation>皮膚より先で切離する部分は、メッシュにした体壁の端で終わります</translation>
    </message>
    <message>
        <source>End the tour</source>
        <translation>ツアーを終える</translation>
    </message>
    <message>
        <source>Back to planning</source>
        <translation>計画に戻る</translation>
    </message>
    <message>
        <source>●  %1</source>
        <translation>●  %1</translation>
    </message>
    <message>
        <source>Computed as</source>
        <translation>計算のしかた</translation>
    </message>
    <message>
        <source>Elements that turned inside out. The numbers near them are wrong.</source>
        <translation>裏返った要素。その近くの数値は正しくない。</translation>
    </message>
    <message>
        <source>Equilibrium</source>
        <translation>釣り合い</translation>
    </message>
    <message>
        <source>Whether the computation found the equilibrium.</source>
        <translation>計算が釣り合いを見つけたか。</translation>
    </message>
    <message>
        <source>converged</source>
        <translation>見つかった</translation>
    </message>
    <message>
        <source>Fields that were computed differently cannot be compared.</source>
        <translation>計算のしかたが違う術野は比べられない。</translation>
    </message>
    <message>
        <source>Inverted</source>
        <translation>裏返り</translation>
    </message>
    <message>
        <source>Planning time</source>
        <translation>計画の時間</translation>
    </message>
    <message>
        <source>Tetrahedra</source>
        <translation>四面体</translation>
    </message>
    <message>
        <source>Rim of the model</source>
        <translation>モデルの縁</translation>
    </message>
    <message>
        <source>Largest motion where the model ends. The model holds the whole wall in the image.</source>
        <translation>モデルの端での最大の動き。モデルは画像の胸壁全体を含む。</translation>
    </message>
    <message>
        <source>Largest motion where the model ends. %1</source>
        <translation>モデルの端での最大の動き。%1</translation>
    </message>
    <message>
        <source>Soft tissue off its volume</source>
        <translation>体積の合わない軟部組織</translation>
    </message>
    <message>
        <source>Share of the soft tissue that shrinks or grows by more than a tenth. Soft tissue keeps its volume, so the numbers near such tissue are wrong.</source>
        <translation>体積が一割より大きく変わる軟部組織の割合。軟部組織の体積は変わらないので、その近くの数値は正しくない。</translation>
    </message>
    <message>
        <source>corotational; four-node elements, Poisson's ratios at most 0.45</source>
        <translation>共回転、四節点要素、ポアソン比 0.45 以下</translation>
    </message>
    <message>
        <source>corotational; ten-node elements</source>
        <translation>共回転、十節点要素</translation>
    </message>
    <message>
        <source>Contact</source>
        <translation>接触</translation>
    </message>
    <message>
        <source>not tested</source>
        <translation>調べていない</translation>
    </message>
    <message>
        <source>nothing touches</source>
        <translation>接触なし</translation>
    </message>
    <message>
        <source>%1 points touch</source>
        <translation>%1 点が接触</translation>
    </message>
    <message>
        <source>%1 mm passed through</source>
        <translation>%1 mm 通り抜け</translation>
    </message>
    <message>
        <source>Largest relative residual force</source>
        <translation>残差の最大</translation>
    </message>
    <message>
        <source>Instrument</source>
        <translation>器械</translation>
    </message>
    <message>
        <source>Peak %1 N (%2 to %3), held %4 N after %5.</source>
        <translation>最大 %1 N（%2 〜 %3 N）、%5後の保持力 %4 N。</translation>
    </message>
    <message>
        <source>Peak %1 N (%2 to %3).</source>
        <translation>最大 %1 N（%2 〜 %3 N）。</translation>
    </message>
    <message>
        <source>Force %1 N (%2 to %3).</source>
        <translation>力 %1 N（%2 〜 %3 N）。</translation>
    </message>
    <message>
        <source>%1 minutes</source>
        <translation>%1 分</translation>
    </message>
    <message>
        <source>Rib %1 on the left would break from %2 mm on.</source>
        <translation>左第 %1 肋骨は %2 mm から折れる見込みです。</translation>
    </message>
    <message>
        <source>Rib %1 on the right would break from %2 mm on.</source>
        <translation>右第 %1 肋骨は %2 mm から折れる見込みです。</translation>
    </message>
    <message>
        <source>Rib %1 on the left comes near breaking.</source>
        <translation>左第 %1 肋骨は折れそうです。</translation>
    </message>
    <message>
        <source>Rib %1 on the right comes near breaking.</source>
        <translation>右第 %1 肋骨は折れそうです。</translation>
    </message>
    <message>
        <source>Rib %1 on the left</source>
        <translation>左第 %1 肋骨</translation>
    </message>
    <message>
        <source>Rib %1 on the right</source>
        <translation>右第 %1 肋骨</translation>
    </message>
    <message>
        <source>rib %1 on the left</source>
        <translation>左第 %1 肋骨</translation>
    </message>
    <message>
        <source>rib %1 on the right</source>
        <translation>右第 %1 肋骨</translation>
    </message>
    <message>
        <source>pulmonary artery</source>
        <translation>肺動脈</translation>
    </message>
    <message>
        <source>A  %1</source>
        <translation>A  %1</translation>
    </message>
    <message>
        <source>B  %1</source>
        <translation>B  %1</translation>
    </message>
    <message>
        <source>C  %1</source>
        <translation>C  %1</translation>
    </message>
    <message>
        <source>D  %1</source>
        <translation>D  %1</translation>
    </message>
    <message>
        <source>Preparing the wall for cutting: %1</source>
        <translation>体壁の切開を準備しています：%1</translation>
    </message>
    <message>
        <source>read labels</source>
        <translation>ラベルの読み込み</translation>
    </message>
    <message>
        <source>labels</source>
        <translation>ラベル</translation>
    </message>
    <message>
        <source>voxels</source>
        <translation>ボクセル</translation>
    </message>
    <message>
        <source>opening</source>
        <translation>開創</translation>
    </message>
    <message>
        <source>look for fragments</source>
        <translation>離れた片の探索</translation>
    </message>
    <message>
        <source>repair labels</source>
        <translation>ラベルの修復</translation>
    </message>
    <message>
        <source>read CT</source>
        <translation>CT の読み込み</translation>
    </message>
    <message>
        <source>segmentation</source>
        <translation>セグメンテーション</translation>
    </message>
    <message>
        <source>bones</source>
        <translation>骨</translation>
    </message>
    <message>
        <source>tetrahedra</source>
        <translation>四面体</translation>
    </message>
    <message>
        <source>label surface</source>
        <translation>ラベルの表面</translation>
    </message>
    <message>
        <source>viewing surface</source>
        <translation>表示用の表面</translation>
    </message>
    <message>
        <source>exposure</source>
        <translation>視野</translation>
    </message>
    <message>
        <source>best eye</source>
        <translation>最良の目</translation>
    </message>
    <message>
        <source>instruments</source>
        <translation>器械</translation>
    </message>
    <message>
        <source>pictures</source>
        <translation>画像</translation>
    </message>
    <message>
        <source>small pictures</source>
        <translation>小さな画像</translation>
    </message>
    <message>
        <source>cutting session</source>
        <translation>切開の準備</translation>
    </message>
    <message>
        <source>assembly</source>
        <translation>組み立て</translation>
    </message>
    <message>
        <source>solver</source>
        <translation>ソルバ</translation>
    </message>
    <message>
        <source>ray tracer</source>
        <translation>視線の計算</translation>
    </message>
    <message>
        <source>begin</source>
        <translation>開始</translation>
    </message>
    <message>
        <source>cancelling</source>
        <translation>中止中</translation>
    </message>
    <message>
        <source>Take the last cut or the last change of the hooks back (Ctrl+Z)</source>
        <translation>直前の切開または鉤の変更を取り消す (Ctrl+Z)</translation>
    </message>
    <message>
        <source>Make it again (Ctrl+Shift+Z)</source>
        <translation>もう一度行う (Ctrl+Shift+Z)</translation>
    </message>
    <message>
        <source>setting the hook</source>
        <translation>鉤をかける</translation>
    </message>
    <message>
        <source>setting the retractor</source>
        <translation>開創器をかける</translation>
    </message>
    <message>
        <source>cranking the retractor</source>
        <translation>開創器を開く</translation>
    </message>
    <message>
        <source>opening as planned</source>
        <translation>計画どおり開く</translation>
    </message>
    <message>
        <source>moving the %1</source>
        <translation>%1を動かす</translation>
    </message>
    <message>
        <source>opening all hooks</source>
        <translation>すべての鉤を開く</translation>
    </message>
    <message>
        <source>taking off the %1</source>
        <translation>%1を外す</translation>
    </message>
    <message>
        <source>taking off all hooks</source>
        <translation>すべての鉤を外す</translation>
    </message>
    <message>
        <source>hook %1</source>
        <translation>鉤 %1</translation>
    </message>
    <message>
        <source>left blade</source>
        <translation>左のブレード</translation>
    </message>
    <message>
        <source>right blade</source>
        <translation>右のブレード</translation>
    </message>
    <message>
        <source>upper blade</source>
        <translation>上のブレード</translation>
    </message>
    <message>
        <source>lower blade</source>
        <translation>下のブレード</translation>
    </message>
    <message>
        <source>front blade</source>
        <translation>前のブレード</translation>
    </message>
    <message>
        <source>back blade</source>
        <translation>後ろのブレード</translation>
    </message>
    <message>
        <source>planned %1</source>
        <translation>計画した%1</translation>
    </message>
    <message>
        <source>%1 (no longer in the case)</source>
        <translation>%1（もう症例にない）</translation>
    </message>
    <message>
        <source>Chosen: %1, by %2 on %3</source>
        <translation>決定：%1、%2、%3</translation>
    </message>
    <message>
        <source>%1   %2 mm, %3</source>
        <translation>%1   %2 mm、%3</translation>
    </message>
    <message>
        <source>The best eye sees %1 % of the target (± %2), %3° off the straight view; %4 s ago.</source>
        <translation>最良の目に標的の %1 % が見える（± %2）、正面から %3° 傾く、%4 秒前。</translation>
    </message>
    <message>
        <source>The best eye sees %1 % of the target (± %2), %3° off the straight view.</source>
        <translation>最良の目に標的の %1 % が見える（± %2）、正面から %3° 傾く。</translation>
    </message>
    <message>
        <source>The best eye sees %1 % of the target (± %2); %3 s ago.</source>
        <translation>最良の目に標的の %1 % が見える（± %2）、%3 秒前。</translation>
    </message>
    <message>
        <source>The best eye sees %1 % of the target (± %2).</source>
        <translation>最良の目に標的の %1 % が見える（± %2）。</translation>
    </message>
    <message>
        <source>Here the tissue is under %1 tension, in the plan under %2 tension: the wound opens differently</source>
        <translation>ここでの張りは %1、計画では %2 です。創の開き方が違います</translation>
    </message>
    <message>
        <source>Here the tissue is under %1 tension, in the plan under no tension: the wound opens differently</source>
        <translation>ここでの張りは %1、計画では張りなしです。創の開き方が違います</translation>
    </message>
    <message>
        <source>Here the tissue is under no tension, in the plan under %1 tension: the wound opens differently</source>
        <translation>ここでは張りなし、計画での張りは %1 です。創の開き方が違います</translation>
    </message>
    <message>
        <source>%1: through the incision</source>
        <translation>%1：切開からの眺め</translation>
    </message>
    <message>
        <source>%1, through the incision</source>
        <translation>%1：切開からの眺め</translation>
    </message>
    <message>
        <source>%1: overview</source>
        <translation>%1：全体</translation>
    </message>
    <message>
        <source>%1: incision</source>
        <translation>%1：切開</translation>
    </message>
    <message>
        <source>%1: by hand</source>
        <translation>%1：手による切開</translation>
    </message>
    <message>
        <source>overview</source>
        <translation>全体</translation>
    </message>
    <message>
        <source>patient</source>
        <translation>患者</translation>
    </message>
    <message>
        <source>largest elongation</source>
        <translation>最大の伸び</translation>
    </message>
    <message>
        <source>samples of skin tore</source>
        <translation>皮膚の試料が裂けた</translation>
    </message>
    <message>
        <source>colours: single places; the verdict takes means over balls</source>
        <translation>色：各点の値。判定は球での平均による</translation>
    </message>
    <message>
        <source>pressure of the blades on the lips</source>
        <translation>創縁にかかるブレードの圧力</translation>
    </message>
    <message>
        <source>colours: force of a third over a third of what touches</source>
        <translation>色：接触部の三分の一にかかる力の三分の一</translation>
    </message>
    <message>
        <source>nearest structure at risk</source>
        <translation>最も近い損傷してはならない構造</translation>
    </message>
    <message>
        <source>organs where the CT shows them</source>
        <translation>臓器は CT の位置</translation>
    </message>
    <message>
        <source>eyes that see the place</source>
        <translation>その位置が見える目</translation>
    </message>
    <message>
        <source>reach through the wound</source>
        <translation>創を通して届く範囲</translation>
    </message>
    <message>
        <source>finger and two instruments</source>
        <translation>指と二本の器械</translation>
    </message>
    <message>
        <source>two instruments</source>
        <translation>二本の器械</translation>
    </message>
    <message>
        <source>neither</source>
        <translation>どちらも届かない</translation>
    </message>
    <message>
        <source>instruments: where the best eye sees the place</source>
        <translation>器械：最良の目に見える所のみ</translation>
    </message>
    <message>
        <source>eyes of the cone</source>
        <translation>円錐の目の数</translation>
    </message>
    <message>
        <source>share of the target's area seen from there</source>
        <translation>そこから見える標的の面積の割合</translation>
    </message>
    <message>
        <source>the best place of the eye: %1 % of what could be seen</source>
        <translation>最良の目の位置：見えうるものの %1 %</translation>
    </message>
    <message>
        <source>the other places: distance from the target</source>
        <translation>ほかの目の位置：標的からの距離</translation>
    </message>
    <message>
        <source>axial, incision within %1 mm</source>
        <translation>横断、切開（%1 mm以内）</translation>
    </message>
    <message>
        <source>coronal, incision within %1 mm</source>
        <translation>冠状断、切開（%1 mm以内）</translation>
    </message>
    <message>
        <source>sagittal, incision within %1 mm</source>
        <translation>矢状断、切開（%1 mm以内）</translation>
    </message>
    <message>
        <source>axial</source>
        <translation>横断</translation>
    </message>
    <message>
        <source>coronal</source>
        <translation>冠状断</translation>
    </message>
    <message>
        <source>sagittal</source>
        <translation>矢状断</translation>
    </message>
    <message>
        <source>%1, by hand</source>
        <translation>%1、手による切開</translation>
    </message>
    <message>
        <source>along the incision</source>
        <translation>切開に沿って</translation>
    </message>
    <message>
        <source>across the incision</source>
        <translation>切開に直交して</translation>
    </message>
    <message>
        <source>%1 mm deep</source>
        <translation>深さ %1 mm</translation>
    </message>
    <message>
        <source>across its middle</source>
        <translation>中央で直交</translation>
    </message>
    <message>
        <source>Choose a folder…</source>
        <translation>フォルダを選ぶ…</translation>
    </message>
    <message>
        <source>Make the step that was undone last again (Ctrl+Shift+Z)</source>
        <translation>最後に取り消した操作をもう一度行う (Ctrl+Shift+Z)</translation>
    </message>
    <message>
        <source>With %1, %2 shows most (%3 %), not %4 (%5 %).</source>
        <translation>%1では、%4 (%5 %) でなく %2 が最もよく見えます (%3 %)。</translation>
    </message>
    <message>
        <source>The %1 would break from %2 mm on.</source>
        <translation>%1は %2 mm から折れる見込みです。</translation>
    </message>
    <message>
        <source>The %1 comes near breaking.</source>
        <translation>%1は折れそうです。</translation>
    </message>
    <message>
        <source>the %1</source>
        <translation>%1</translation>
    </message>
    <message>
        <source>with injury: %1</source>
        <translation>損傷を伴う：%1</translation>
    </message>
    <message>
        <source>The approaches have different targets, so what is seen of them is not compared.</source>
        <translation>アプローチの標的が違うので、見える割合は比べません。</translation>
    </message>
    <message>
        <source>upper blade %1</source>
        <translation>上のブレード %1</translation>
    </message>
    <message>
        <source>lower blade %1</source>
        <translation>下のブレード %1</translation>
    </message>
    <message>
        <source>left blade %1</source>
        <translation>左のブレード %1</translation>
    </message>
    <message>
        <source>right blade %1</source>
        <translation>右のブレード %1</translation>
    </message>
    <message>
        <source>front blade %1</source>
        <translation>前のブレード %1</translation>
    </message>
    <message>
        <source>back blade %1</source>
        <translation>後ろのブレード %1</translation>
    </message>
    <message>
        <source>%1 blade and %2 blade</source>
        <translation>%1のブレードと%2のブレード</translation>
    </message>
    <message>
        <source>upper</source>
        <translation>上</translation>
    </message>
    <message>
        <source>lower</source>
        <translation>下</translation>
    </message>
    <message>
        <source>front</source>
        <translation>前</translation>
    </message>
    <message>
        <source>back</source>
        <translation>後ろ</translation>
    </message>
    <message>
        <source>left</source>
        <translation>左</translation>
    </message>
    <message>
        <source>right</source>
        <translation>右</translation>
    </message>
    <message>
        <source>%1 has lost its tissue and was removed</source>
        <translation>%1は組織から外れたので取り除きました</translation>
    </message>
    <message>
        <source>the %1 has lost its tissue and was removed</source>
        <translation>%1は組織から外れたので取り除きました</translation>
    </message>
    <message>
        <source>a hook or blade already holds the wound here: drag it, or press farther away from it</source>
        <translation>ここにはすでに鉤またはブレードがかかっています。それをドラッグするか、離れた所を押してください</translation>
    </message>
    <message>
        <source>the wall cannot be opened: %1</source>
        <translation>体壁を開けません：%1</translation>
    </message>
    <message>
        <source>both blades must find a hold: %1</source>
        <translation>両方のブレードが組織にかからなければなりません：%1</translation>
    </message>
    <message>
        <source>all hooks were removed: %1</source>
        <translation>すべての鉤を外しました：%1</translation>
    </message>
    <message>
        <source>read labels %1 %</source>
        <translation>ラベルの読み込み %1 %</translation>
    </message>
    <message>
        <source>labels %1 %</source>
        <translation>ラベル %1 %</translation>
    </message>
    <message>
        <source>tetrahedra %1 %</source>
        <translation>四面体 %1 %</translation>
    </message>
    <message>
        <source>label surface %1 %</source>
        <translation>ラベルの表面 %1 %</translation>
    </message>
    <message>
        <source>building the model of the wall %1 %</source>
        <translation>体壁のモデルを作成中 %1 %</translation>
    </message>
    <message>
        <source>look for fragments %1 %</source>
        <translation>離れた片の探索 %1 %</translation>
    </message>
    <message>
        <source>repair labels %1 %</source>
        <translation>ラベルの修復 %1 %</translation>
    </message>
    <message>
        <source>read CT %1 %</source>
        <translation>CT の読み込み %1 %</translation>
    </message>
    <message>
        <source>cutting session %1 %</source>
        <translation>切開の準備 %1 %</translation>
    </message>
    <message>
        <source>voxels %1 %</source>
        <translation>ボクセル %1 %</translation>
    </message>
    <message>
        <source> of %1</source>
        <translation> / %1</translation>
    </message>
    <message>
        <source>Aneurysm</source>
        <translation>動脈瘤</translation>
    </message>
    <message>
        <source>Aorta</source>
        <translation>大動脈</translation>
    </message>
    <message>
        <source>Heart</source>
        <translation>心臓</translation>
    </message>
    <message>
        <source>Trachea</source>
        <translation>気管</translation>
    </message>
    <message>
        <source>Left lung</source>
        <translation>左肺</translation>
    </message>
    <message>
        <source>Right lung</source>
        <translation>右肺</translation>
    </message>
    <message>
        <source>Pulmonary trunk</source>
        <translation>肺動脈幹</translation>
    </message>
    <message>
        <source>Pulmonary artery</source>
        <translation>肺動脈</translation>
    </message>
    <message>
        <source>Superior vena cava</source>
        <translation>上大静脈</translation>
    </message>
    <message>
        <source>Inferior vena cava</source>
        <translation>下大静脈</translation>
    </message>
    <message>
        <source>Left atrium</source>
        <translation>左心房</translation>
    </message>
    <message>
        <source>Spine</source>
        <translation>脊椎</translation>
    </message>
    <message>
        <source>Liver</source>
        <translation>肝臓</translation>
    </message>
    <message>
        <source>Muscle</source>
        <translation>筋</translation>
    </message>
    <message>
        <source>Fat</source>
        <translation>脂肪</translation>
    </message>
    <message>
        <source>Cartilage</source>
        <translation>軟骨</translation>
    </message>
    <message>
        <source>Palpate through the wound</source>
        <translation>創を通して触診</translation>
    </message>
    <message>
        <source>Touch the target of the planned approach through its opened wound, in a new window</source>
        <translation>計画したアプローチの標的を、開いた創を通して新しいウィンドウで触れる</translation>
    </message>
    <message>
        <source>Preparing the target for palpation through the wound …</source>
        <translation>創を通した触診のため標的を準備しています…</translation>
    </message>
    <message>
        <source>Retractor - palpation through the wound: %1</source>
        <translation>Retractor - 創を通した触診：%1</translation>
    </message>
    <message>
        <source>It is too short for this place.</source>
        <translation>この場所には長さが足りません。</translation>
    </message>
    <message>
        <source>It is stopped by: %1.</source>
        <translation>止めているもの：%1。</translation>
    </message>
    <message>
        <source>Reach in with</source>
        <translation>創に入れるもの</translation>
    </message>
    <message>
        <source>What is put through the wound: an index finger, or the shaft of an instrument</source>
        <translation>創に入れるもの：示指または器具のシャフト</translation>
    </message>
    <message>
        <source>an instrument</source>
        <translation>器具</translation>
    </message>
    <message>
        <source>a finger</source>
        <translation>指</translation>
    </message>
    <message>
        <source>stopped</source>
        <translation>停止</translation>
    </message>
    <message>
        <source>A straight %1, %2 mm thick and up to %3 mm long, reaches %4 % of the whole surface shown here; what it does not reach is dark.</source>
        <translation>まっすぐな%1（太さ %2 mm、長さ %3 mm まで）は、ここに示す表面全体の %4 % に届きます。届かない所は暗く示します。</translation>
    </message>
    <message>
        <source>finger</source>
        <translation>指</translation>
    </message>
    <message>
        <source>instrument</source>
        <translation>器具</translation>
    </message>
    <message>
        <source>What it should touch lies in its way.</source>
        <translation>触れるはずの構造自体が途中にあります。</translation>
    </message>
    <message>
        <source>%1: palpation through the wound</source>
        <translation>%1：創を通した触診</translation>
    </message>
    <message>
        <source>chest wall</source>
        <translation>胸壁</translation>
    </message>
    <message>
        <source>chest wall beyond the model</source>
        <translation>モデルの外の胸壁</translation>
    </message>
    <message>
        <source>end of the image</source>
        <translation>画像の端</translation>
    </message>
    <message>
        <source>its plan is not saved beside the case: plan it again</source>
        <translation>計画が症例と一緒に保存されていません。もう一度計画してください</translation>
    </message>
    <message>
        <source>the target lies in no organ that can be palpated</source>
        <translation>標的は触診できる臓器の中にありません</translation>
    </message>
    <message>
        <source>Planned surgical fields</source>
        <translation>計画した術野</translation>
    </message>
    <message>
        <source>Labels of %1 voxels at %2 mm, patient frame LPS.</source>
        <translation>ラベル：%1 ボクセル、間隔 %2 mm、患者座標系 LPS。</translation>
    </message>
    <message>
        <source>Research software, not a medical device.</source>
        <translation>研究用ソフトウェアであり、医療機器ではありません。</translation>
    </message>
    <message>
        <source>... reached by the tissue under them</source>
        <translation>…その下の組織の動き</translation>
    </message>
    <message>
        <source>Force on a side and its moment</source>
        <translation>片側の力とその時点</translation>
    </message>
    <message>
        <source>force on a side: %1 N at the last turn, about %2 N after 5 minutes (%3 N between animals); opened by half a turn of the crank (%4 mm) every %5 s, in %6 s</source>
        <translation>片側の力：最後の一回しで %1 N、5 分後に約 %2 N（動物間で %3 N）。クランク半回転（%4 mm）を %5 秒ごと、%6 秒で開く</translation>
    </message>
    <message>
        <source>Bone in the line of sight</source>
        <translation>視線上の骨</translation>
    </message>
    <message>
        <source>Nearest structures at risk, from the blade</source>
        <translation>刃から最も近い危険構造</translation>
    </message>
    <message>
        <source>Nearest structures at risk, from hooks and retractor</source>
        <translation>鉤・開創器から最も近い危険構造</translation>
    </message>
    <message>
        <source>Hooks and blades bear on</source>
        <translation>鉤とブレードのかかる所</translation>
    </message>
    <message>
        <source>Largest strain of each tissue, over balls of 5 mm radius</source>
        <translation>各組織の最大ひずみ（半径 5 mm の球で平均）</translation>
    </message>
    <message>
        <source>Caution, tearing</source>
        <translation>注意：裂傷</translation>
    </message>
    <message>
        <source>Intercostal space divided beyond the skin</source>
        <translation>皮膚切開を越えて切離した肋間</translation>
    </message>
    <message>
        <source>skin only</source>
        <translation>皮膚のみ</translation>
    </message>
    <message>
        <source>%1 mm backwards, %2 mm forwards</source>
        <translation>後方へ %1 mm、前方へ %2 mm</translation>
    </message>
    <message>
        <source>Mechanics</source>
        <translation>力学計算</translation>
    </message>
    <message>
        <source>converged; inverted %1, largest volume ratio %2</source>
        <translation>収束、反転した要素 %1、最大の体積比 %2</translation>
    </message>
    <message>
        <source>Solved as</source>
        <translation>解き方</translation>
    </message>
    <message>
        <source>What the best eye sees is a share of what an eye would see with the wall removed; what the eyes of the cone see is a share of the target's whole area, and so may be smaller.</source>
        <translation>最良の眼に見える割合は、胸壁を取り除いたときに見えるはずの範囲に対するものです。円錐内の眼に見える割合は標的の全面積に対するもので、より小さくなりえます。</translation>
    </message>
    <message>
        <source>Green: better than every other approach by more than both error bars together.</source>
        <translation>緑：他のどのアプローチよりも、両方の誤差を合わせた以上に優れています。</translation>
    </message>
    <message>
        <source>Without a mark the lead is within the error, or the error is unknown.</source>
        <translation>印がなければ差は誤差の範囲内か、誤差が分かりません。</translation>
    </message>
    <message>
        <source>Leads in these shares are compared with this bar or that of the best eye, whichever is larger.</source>
        <translation>これらの割合の差は、この誤差と最良の眼の誤差の大きい方と比べます。</translation>
    </message>
    <message>
        <source>The score is the weighted mean of the criteria, each 0 to 100 between two fixed values.</source>
        <translation>評点は各基準（固定した二つの値の間で 0 〜 100）の加重平均です。</translation>
    </message>
    <message>
        <source>Weights and values are a choice, not a finding:</source>
        <translation>重みと値は選択であり、知見ではありません：</translation>
    </message>
    <message>
        <source>takes others.</source>
        <translation>で変えられます。</translation>
    </message>
    <message>
        <source>target seen (weight %1)</source>
        <translation>標的の見え方（重み %1）</translation>
    </message>
    <message>
        <source>reached by instruments (weight %1)</source>
        <translation>器具の届きやすさ（重み %1）</translation>
    </message>
    <message>
        <source>straight view (weight %1)</source>
        <translation>まっすぐな視野（重み %1）</translation>
    </message>
    <message>
        <source>short incision (weight %1)</source>
        <translation>切開の短さ（重み %1）</translation>
    </message>
    <message>
        <source>bone spared (weight %1)</source>
        <translation>骨の温存（重み %1）</translation>
    </message>
    <message>
        <source>structures far (weight %1)</source>
        <translation>構造からの距離（重み %1）</translation>
    </message>
    <message>
        <source>low force (weight %1)</source>
        <translation>力の小ささ（重み %1）</translation>
    </message>
    <message>
        <source>shows (points of its criteria)</source>
        <translation>見せる力（基準の点）</translation>
    </message>
    <message>
        <source>spares (points of its criteria)</source>
        <translation>温存する力（基準の点）</translation>
    </message>
    <message>
        <source>The letters are those of the table.</source>
        <translation>文字は表のものです。</translation>
    </message>
    <message>
        <source>Right: the approach shows more.</source>
        <translation>右：よりよく見えます。</translation>
    </message>
    <message>
        <source>Up: it spares more (incision, bone, structures at risk, force).</source>
        <translation>上：より多くを温存します（切開、骨、危険構造、力）。</translation>
    </message>
    <message>
        <source>An open circle: another approach is at least as good by every criterion, and better by one.</source>
        <translation>白丸：他のアプローチがすべての基準で同等以上、少なくとも一つで優れています。</translation>
    </message>
    <message>
        <source>One space higher or lower</source>
        <translation>一肋間上または下</translation>
    </message>
    <message>
        <source>Not planned for %1.</source>
        <translation>%1は計画されていません。</translation>
    </message>
    <message>
        <source>, or B in the window, plans them.</source>
        <translation>、またはウィンドウの B で計画します。</translation>
    </message>
    <message>
        <source>%1 caution: %2 % of the soft tissue changes its volume by more than a tenth, to between %3 and %4 of its volume at rest, most of all %5 mm along the incision, %6 mm beside it and %7 mm deep; strain is wrong there.</source>
        <translation>%1 注意：軟部組織の %2 % で体積が 1 割以上変わり、静止時の %3 〜 %4 倍になります（最大は切開に沿って %5 mm、横に %6 mm、深さ %7 mm）。そこのひずみは正しくありません。</translation>
    </message>
    <message>
        <source>%1 caution: %2 % of the soft tissue changes its volume by more than a tenth, to between %3 and %4 of its volume at rest, most of all %5 mm before the start of the incision, %6 mm beside it and %7 mm deep; strain is wrong there.</source>
        <translation>%1 注意：軟部組織の %2 % で体積が 1 割以上変わり、静止時の %3 〜 %4 倍になります（最大は切開の始点の手前 %5 mm、横に %6 mm、深さ %7 mm）。そこのひずみは正しくありません。</translation>
    </message>
    <message>
        <source>%1 caution: %2 % of the soft tissue changes its volume by more than a tenth, to between %3 and %4 of its volume at rest, most of all %5 mm beyond the end of the incision, %6 mm beside it and %7 mm deep; strain is wrong there.</source>
        <translation>%1 注意：軟部組織の %2 % で体積が 1 割以上変わり、静止時の %3 〜 %4 倍になります（最大は切開の終点の先 %5 mm、横に %6 mm、深さ %7 mm）。そこのひずみは正しくありません。</translation>
    </message>
    <message>
        <source>Full median sternotomy: the midline of the sternum, found in its label, from %1 mm above the notch to %2 mm below the xiphoid, put on the skin square to the bone.</source>
        <translation>胸骨正中全切開：ラベルから求めた胸骨の正中線を、切痕の %1 mm 上から剣状突起の %2 mm 下まで、骨に垂直に皮膚へ移しました。</translation>
    </message>
    <message>
        <source>The sternum (%1 mm long) is sawn through; ribs and spine are not cut.</source>
        <translation>胸骨（長さ %1 mm）を鋸断します。肋骨と脊椎は切りません。</translation>
    </message>
    <message>
        <source>The wall along it is %1 mm thick; the blade goes %2 mm deep.</source>
        <translation>これに沿う胸壁の厚さは %1 mm、刃の深さは %2 mm です。</translation>
    </message>
    <message>
        <source>The best eye sees %1 % of what an eye would see of the %2 with the wall removed.</source>
        <translation>最良の眼には、胸壁がなければ見える%2の %1 % が見えます。</translation>
    </message>
    <message>
        <source>Of the side of the target that faces this eye, %1 % is seen.</source>
        <translation>この眼に向いた標的の面の %1 % が見えます。</translation>
    </message>
    <message>
        <source>Of the side of the target that faces the middle of the cone, %1 % is seen.</source>
        <translation>円錐の中央に向いた標的の面の %1 % が見えます。</translation>
    </message>
    <message>
        <source>The rest is hidden by %1.</source>
        <translation>残りを隠すもの：%1。</translation>
    </message>
    <message>
        <source>Share of the lines of sight from the cone that meet bone, also behind other tissue: %1.</source>
        <translation>円錐からの視線のうち骨に当たる割合（他の組織の後ろも含む）：%1。</translation>
    </message>
    <message>
        <source>Part of this bone would have to be pulled further or removed to see more.</source>
        <translation>さらに見るには、この骨の一部をもっと引くか取り除く必要があります。</translation>
    </message>
    <message>
        <source>The skin opens by %1 mm over an incision of %2 mm, and the target lies %3 mm below it.</source>
        <translation>皮膚は %2 mm の切開で %1 mm 開き、標的はその %3 mm 下にあります。</translation>
    </message>
    <message>
        <source>The interactive view appears here when it comes into sight; it needs JavaScript.</source>
        <translation>操作できる 3D 表示は画面に入るとここに現れます（JavaScript が必要です）。</translation>
    </message>
    <message>
        <source>The pictures below show the same field.</source>
        <translation>下の図は同じ術野です。</translation>
    </message>
    <message>
        <source>The surgeon's eye: through the opened incision, target highlighted.</source>
        <translation>術者の眼：開いた切開を通して。標的を強調しています。</translation>
    </message>
    <message>
        <source>Overview of the opened patient.</source>
        <translation>開いた患者の全体像。</translation>
    </message>
    <message>
        <source>Slices through the target, with the incision where it lies near them (cyan), and along and across the incision, with the cut to its depth.</source>
        <translation>標的を通る断面（近くにある切開を水色で表示）と、切開に沿う断面・直交する断面（切離の深さまで）。</translation>
    </message>
    <message>
        <source>To check on the skin in the theatre: The incision starts on the midline and ends on the midline.</source>
        <translation>手術室で皮膚上で確かめること：切開は正中に始まり正中に終わります。</translation>
    </message>
    <message>
        <source>To check on the skin in the theatre: The incision starts %1 mm to the patient's %2 of the midline and ends %3 mm to the patient's %4 of the midline.</source>
        <translation>手術室で皮膚上で確かめること：切開は正中から患者の%2へ %1 mm に始まり、%4へ %3 mm に終わります。</translation>
    </message>
    <message>
        <source>From the jugular notch %1 mm to its start and %2 mm to its end, in a straight line.</source>
        <translation>頸切痕から直線で、始点まで %1 mm、終点まで %2 mm。</translation>
    </message>
    <message>
        <source>From the tip of the xiphoid %1 mm to its start and %2 mm to its end, in a straight line.</source>
        <translation>剣状突起の先端から直線で、始点まで %1 mm、終点まで %2 mm。</translation>
    </message>
    <message>
        <source>The best eye is %1 mm from the opening and meets what it sees at %2 degrees on average; it was searched within %3 degrees of the cone's axis.</source>
        <translation>最良の眼は開口部から %1 mm で、見える面に平均 %2 度で当たります。円錐の軸から %3 度以内で探しました。</translation>
    </message>
    <message>
        <source>The best eye is %1 mm from the opening; it was searched within %2 degrees of the cone's axis.</source>
        <translation>最良の眼は開口部から %1 mm です。円錐の軸から %2 度以内で探しました。</translation>
    </message>
    <message>
        <source>The mean and the union are over %1 eyes %2 mm from the target; %3 samples on the target.</source>
        <translation>平均と合併は標的から %2 mm の %1 個の眼によります。標的上の点は %3 個です。</translation>
    </message>
    <message>
        <source>The CT is taken in inspiration: with the organs 10 mm nearer to the head the best eye sees %1 %, 20 mm %2 %; past a lung of 20 % of its volume %3 %, past a lung of 50 % of its volume %4 %.</source>
        <translation>CT は吸気位です。臓器が 10 mm 頭側なら最良の眼に %1 %、20 mm なら %2 %。肺が体積の 20 % なら %3 %、50 % なら %4 % が見えます。</translation>
    </message>
    <message>
        <source>The picture from the best eye shows %1 % of the target, counted in pixels; rays give %2 %.</source>
        <translation>最良の眼からの図では画素で数えて標的の %1 % が見えます。光線では %2 %。</translation>
    </message>
    <message>
        <source>How far each lip hangs behind its blade (mm)</source>
        <translation>各創縁がブレードから遅れる距離（mm）</translation>
    </message>
    <message>
        <source>%1 mm along the incision</source>
        <translation>切開に沿って %1 mm</translation>
    </message>
    <message>
        <source>left lip</source>
        <translation>左の創縁</translation>
    </message>
    <message>
        <source>right lip</source>
        <translation>右の創縁</translation>
    </message>
    <message>
        <source>No rib reaches the moment at which tested ribs broke.</source>
        <translation>試験で折れた肋骨のモーメントに達する肋骨はありません。</translation>
    </message>
    <message>
        <source>%1 comes nearest: %2 N m in its %3 part, %4 mm from the spine, which is %5 % of the %6 N m of tested ribs.</source>
        <translation>最も近いのは%1：%3部、脊椎から %4 mm で %2 N m、試験された肋骨の %6 N m の %5 % です。</translation>
    </message>
    <message>
        <source>lateral</source>
        <translation>外側</translation>
    </message>
    <message>
        <source>posterior</source>
        <translation>後方</translation>
    </message>
    <message>
        <source>anterior</source>
        <translation>前方</translation>
    </message>
    <message>
        <source>The elements of this mesh are too stiff, so these moments are rough.</source>
        <translation>この格子の要素は硬すぎるので、モーメントはおおよそです。</translation>
    </message>
    <message>
        <source>The joint with the spine that bears most is that of %1, with %2 N and %3 N m.</source>
        <translation>脊椎との関節で最も負荷が大きいのは%1で、%2 N と %3 N m です。</translation>
    </message>
    <message>
        <source>The rib that turns most about its joints is %1, by %2 degrees.</source>
        <translation>関節で最も回るのは%1で、%2 度です。</translation>
    </message>
    <message>
        <source>The cartilage that bears most is that of %1, with %2 N and %3 N m.</source>
        <translation>最も負荷の大きい軟骨は%1のもので、%2 N と %3 N m です。</translation>
    </message>
    <message>
        <source>the sternum</source>
        <translation>胸骨</translation>
    </message>
    <message>
        <source>There is no published number for what joint and cartilage bear.</source>
        <translation>関節と軟骨が耐える値は公表されていません。</translation>
    </message>
    <message>
        <source>opening %1 mm +- %2, force %3 N +- %4, seen %5 % +- %6 (discretisation error, estimated in %7 s).</source>
        <translation>開口 %1 mm ± %2、力 %3 N ± %4、見える割合 %5 % ± %6（離散化誤差、推定 %7 秒）。</translation>
    </message>
    <message>
        <source>Errors of the materials, the supports and the model are not included.</source>
        <translation>材料、支持、モデルの誤差は含みません。</translation>
    </message>
    <message>
        <source>Force %1 N; mesh: +- %2 N; tissue values: %3 N; decided by %4.</source>
        <translation>力 %1 N、格子：± %2 N、組織の値：%3 N、主に%4による。</translation>
    </message>
    <message>
        <source>tissue values: force %1 N, opening %2 mm; decided by %3: one standard deviation.</source>
        <translation>組織の値：力 %1 N、開口 %2 mm、主に%3による（1 標準偏差）。</translation>
    </message>
    <message>
        <source>Force and opening change to first order with the values; the bars of the mesh are no part of it.</source>
        <translation>力と開口は値に対して一次で変わります。格子の誤差は含みません。</translation>
    </message>
    <message>
        <source>Stiffness</source>
        <translation>剛性</translation>
    </message>
    <message>
        <source>Planned with</source>
        <translation>計画での値</translation>
    </message>
    <message>
        <source>Force at the upper end</source>
        <translation>上端での力</translation>
    </message>
    <message>
        <source>Opening at the upper end</source>
        <translation>上端での開口</translation>
    </message>
    <message>
        <source>From</source>
        <translation>出典</translation>
    </message>
    <message>
        <source>Found by</source>
        <translation>求め方</translation>
    </message>
    <message>
        <source>bed of the shoulder girdle</source>
        <translation>肩甲帯の床</translation>
    </message>
    <message>
        <source>costovertebral joint</source>
        <translation>肋椎関節</translation>
    </message>
    <message>
        <source>costal cartilages</source>
        <translation>肋軟骨</translation>
    </message>
    <message>
        <source>The model holds the wall within %1 mm of the incision.</source>
        <translation>モデルは切開から %1 mm 以内の胸壁を含みます。</translation>
    </message>
    <message>
        <source>Where it ends, tissue moves by up to %1 mm (%2, %3 mm from the incision towards %4).</source>
        <translation>その端で組織は最大 %1 mm 動きます（%2、切開から %4へ %3 mm）。</translation>
    </message>
    <message>
        <source>Where the image ends, tissue moves by up to %1 mm: what holds it beyond the image is not known.</source>
        <translation>画像の端で組織は最大 %1 mm 動きます。画像の外で何が支えるかは分かりません。</translation>
    </message>
    <message>
        <source>No bar contains the force that the wall beyond would add: on phantoms the force with the whole wall was up to twice as large.</source>
        <translation>その先の胸壁が加える力はどの誤差にも含まれません。ファントムでは胸壁全体での力は最大 2 倍でした。</translation>
    </message>
    <message>
        <source>the left</source>
        <translation>左</translation>
    </message>
    <message>
        <source>the right</source>
        <translation>右</translation>
    </message>
    <message>
        <source>the feet</source>
        <translation>足側</translation>
    </message>
    <message>
        <source>the head</source>
        <translation>頭側</translation>
    </message>
    <message>
        <source>the front</source>
        <translation>前</translation>
    </message>
    <message>
        <source>the back</source>
        <translation>後ろ</translation>
    </message>
    <message>
        <source>contact: nothing touches; surfaces that overlap by up to %1 mm at rest keep this overlap.</source>
        <translation>接触：何も触れません。静止時に最大 %1 mm 重なる面はそのままです。</translation>
    </message>
    <message>
        <source>Lateral thoracotomy, centred just in front of the mid-axillary line.</source>
        <translation>側方開胸。中腋窩線のすぐ前を中心とします。</translation>
    </message>
    <message>
        <source>Left posterolateral thoracotomy for the distal arch and the descending aorta.</source>
        <translation>遠位弓部と下行大動脈のための左後側方開胸。</translation>
    </message>
    <message>
        <source>The line lies about %1 mm above %2 in the %3 intercostal space %4, for %5 mm.</source>
        <translation>線は%3第 %4 肋間で、%2の約 %1 mm 上を %5 mm たどります。</translation>
    </message>
    <message>
        <source>rib %1</source>
        <translation>第 %1 肋骨</translation>
    </message>
    <message>
        <source>The blade keeps at least %1 mm from every bone and cartilage.</source>
        <translation>刃はすべての骨と軟骨から %1 mm 以上離れます。</translation>
    </message>
    <message>
        <source>No straight finger comes to the %1 through the opening.</source>
        <translation>まっすぐな指は開口部から%1に届きません。</translation>
    </message>
    <message>
        <source>A finger touches less than 1 %.</source>
        <translation>指が触れるのは 1 % 未満です。</translation>
    </message>
    <message>
        <source>Two instruments reach %1 of what an eye could see of the %2.</source>
        <translation>二本の器械は、見えうる%2の %1 に届きます。</translation>
    </message>
    <message>
        <source>No eye sees the %1 through the opening at less than 60 degrees of incidence.</source>
        <translation>入射角 60 度未満で開口部から%1を見る眼はありません。</translation>
    </message>
    <message>
        <source>in the %1 intercostal space %2 intercostal muscle and pleura are divided beyond the skin %3 mm backwards (%4) and %5 mm forwards (%6); the division is %7 mm long with the incision, and severs %8 cm2 beyond it.</source>
        <translation>%1第 %2 肋間で、肋間筋と胸膜を皮膚を越えて後方へ %3 mm（%4）、前方へ %5 mm（%6）切離します。切離は切開を含めて長さ %7 mm、その先で %8 cm2 を切ります。</translation>
    </message>
    <message>
        <source>%1 mm from the spine's midline</source>
        <translation>脊椎の正中から %1 mm</translation>
    </message>
    <message>
        <source>%1 mm from the sternum</source>
        <translation>胸骨から %1 mm</translation>
    </message>
    <message>
        <source>%1 mm from the mammary artery</source>
        <translation>内胸動脈から %1 mm</translation>
    </message>
    <message>
        <source>%1 mm from where the mammary artery is assumed</source>
        <translation>内胸動脈の想定位置から %1 mm</translation>
    </message>
    <message>
        <source>the ribs join</source>
        <translation>肋骨が合う所</translation>
    </message>
    <message>
        <source>What was computed</source>
        <translation>計算の内容</translation>
    </message>
    <message>
        <source>Computed</source>
        <translation>計算日時</translation>
    </message>
    <message>
        <source>Case</source>
        <translation>症例</translation>
    </message>
    <message>
        <source>Patient</source>
        <translation>患者</translation>
    </message>
    <message>
        <source>Contact of lips and organs</source>
        <translation>創縁と臓器の接触</translation>
    </message>
    <message>
        <source>computed where surfaces would pass through each other</source>
        <translation>面がすり抜ける所で計算</translation>
    </message>
    <message>
        <source>Pressure on the wall</source>
        <translation>胸壁への圧</translation>
    </message>
    <message>
        <source>Held at</source>
        <translation>支持</translation>
    </message>
    <message>
        <source>Material of the wall</source>
        <translation>胸壁の材料</translation>
    </message>
    <message>
        <source>Law</source>
        <translation>構成則</translation>
    </message>
    <message>
        <source>Tension before the cut</source>
        <translation>切る前の張力</translation>
    </message>
    <message>
        <source>Source</source>
        <translation>出典</translation>
    </message>
    <message>
        <source>What these numbers do not say</source>
        <translation>これらの数値が言わないこと</translation>
    </message>
    <message>
        <source>Each tissue has a published mean stiffness, not the stiffness of this patient.</source>
        <translation>各組織の剛性は公表された平均値で、この患者のものではありません。</translation>
    </message>
    <message>
        <source>The stiffness is the same everywhere in a material.</source>
        <translation>剛性は一つの材料の中で一様です。</translation>
    </message>
    <message>
        <source>Forces are proportional to the stiffness.</source>
        <translation>力は剛性に比例します。</translation>
    </message>
    <message>
        <source>Beyond the meshed region, the model contains only bones and cartilages, up to their joints at the spine.</source>
        <translation>格子の領域の外では、脊椎との関節までの骨と軟骨だけを含みます。</translation>
    </message>
    <message>
        <source>Soft tissue there does not resist the hooks, and the pictures show it at rest.</source>
        <translation>そこの軟部組織は鉤に抵抗せず、図では静止したままです。</translation>
    </message>
    <message>
        <source>Lips, ribs, shoulder blades and organs push against each other without friction where they would pass through each other; organs do not move.</source>
        <translation>創縁、肋骨、肩甲骨、臓器は、すり抜けるはずの所で摩擦なしに押し合います。臓器は動きません。</translation>
    </message>
    <message>
        <source>Fractures are foretold for ribs only, from the mean moments at which 52 tested pieces of ribs broke; single ribs differ from the mean.</source>
        <translation>骨折の予測は肋骨だけで、試験した 52 片が折れた平均モーメントによります。個々の肋骨は平均と異なります。</translation>
    </message>
    <message>
        <source>Age, thin bone and earlier fractures are not considered.</source>
        <translation>年齢、薄い骨、以前の骨折は考慮しません。</translation>
    </message>
    <message>
        <source>The sternum, the joints, the cartilages and the neck of a rib at the spine are not judged.</source>
        <translation>胸骨、関節、軟骨、脊椎側の肋骨頸は判定しません。</translation>
    </message>
    <message>
        <source>Hooks are rigid blades that bear on bone close behind them.</source>
        <translation>鉤は剛体のブレードで、すぐ後ろの骨にかかります。</translation>
    </message>
    <message>
        <source>A hook slips only where it has a force limit or a soft grip.</source>
        <translation>鉤が滑るのは力の上限か柔らかい把持がある所だけです。</translation>
    </message>
    <message>
        <source>Tissue does not tear.</source>
        <translation>組織は裂けません。</translation>
    </message>
    <message>
        <source>Inverted elements are errors of the computation.</source>
        <translation>反転した要素は計算の誤りです。</translation>
    </message>
    <message>
        <source>The sternum is sawn through.</source>
        <translation>胸骨を鋸断します。</translation>
    </message>
    <message>
        <source>The %1 lies %2 mm from the blade that cuts.</source>
        <translation>%1は切る刃から %2 mm にあります。</translation>
    </message>
    <message>
        <source>%1 shows most also when patient, organs or lungs lie otherwise: from %2 % with lungs of %3 % of their volume to %4 % with lungs of %5 % of their volume.</source>
        <translation>患者の体位や、臓器・肺の位置が変わっても%1が最もよく見えます：肺が体積の %3 % で %2 %、%5 % で %4 %。</translation>
    </message>
    <message>
        <source>Planned opening, from side to side</source>
        <translation>予定の開き（側から側まで）</translation>
    </message>
    <message>
        <source>Retractor, force and moment per blade</source>
        <translation>開創器：ブレードごとの力とモーメント</translation>
    </message>
    <message>
        <source>A gap at the border of the region is not a wound.</source>
        <translation>領域の縁のすき間は創ではありません。</translation>
    </message>
    <message>
        <source>Poisson's ratios are limited to 0.45, because the elements used here are too stiff above this value.</source>
        <translation>ポアソン比は 0.45 までです。ここで使う要素はそれ以上では硬すぎるためです。</translation>
    </message>
    <message>
        <source>Lungs that an approach holds aside are deflated to 30 % of their volume at their hilum, an assumption; other organs held aside are removed from the view.</source>
        <translation>アプローチがよける肺は、仮定として肺門で体積の 30 % に虚脱させます。よける他の臓器は視野から除きます。</translation>
    </message>
    <message>
        <source>mediastinal fat</source>
        <translation>縦隔脂肪</translation>
    </message>
    <message>
        <source>the case keeps no name and no id</source>
        <translation>症例は氏名も ID も持ちません</translation>
    </message>
    <message>
        <source>spine; the border of the meshed region</source>
        <translation>脊椎、格子の領域の縁</translation>
    </message>
    <message>
        <source>A hand or an arm at the table must keep the retractor from tilting (%1).</source>
        <translation>開創器が傾かないように、手または手術台のアームで支える必要があります（%1）。</translation>
    </message>
    <message>
        <source>Retractor, kept from tilting</source>
        <translation>開創器：傾き止め</translation>
    </message>
    <message>
        <source>The free frame found no balance: a hand or an arm at the table holds its direction.</source>
        <translation>自由な枠は釣り合いませんでした。手または手術台のアームがその向きを支えます。</translation>
    </message>
    <message>
        <source>Not planned, as the time was over: %1</source>
        <translation>時間切れで計画していません：%1</translation>
    </message>
    <message>
        <source>None of these incisions was planned in time.</source>
        <translation>時間内に計画できた切開はありません。</translation>
    </message>
    <message>
        <source>the free frame found no balance: a hand or an arm at the table holds its direction with %1, and %2 of its blade forces are not balanced</source>
        <translation>自由な枠は釣り合わず、手または手術台のアームが %1 でその向きを支えます。ブレードの力のうち %2 が釣り合っていません</translation>
    </message>
    <message>
        <source>contact: the wall sinks up to %1 mm into the %2, which gives way</source>
        <translation>接触：壁は%2に最大 %1 mm 沈み込みます（柔らかく、押されて退きます）</translation>
    </message>
    <message>
        <source>The plan is made: forces by hand are matched to it</source>
        <translation>計画ができました。手動での力を計画に合わせます</translation>
    </message>
    <message>
        <source>vena cava</source>
        <translation>大静脈</translation>
    </message>
    <message>
        <source>intercostal</source>
        <translation>肋間筋</translation>
    </message>
    <message>
        <source>rib</source>
        <translation>肋骨</translation>
    </message>
    <message>
        <source>bone</source>
        <translation>骨</translation>
    </message>
    <message>
        <source>mediastinum</source>
        <translation>縦隔</translation>
    </message>
    <message>
        <source>upper abdomen</source>
        <translation>上腹部</translation>
    </message>
    <message>
        <source>the %1 opens %2 mm with %3 N along its rack</source>
        <translation>%1はラックに沿う %3 N で %2 mm 開きます</translation>
    </message>
    <message>
        <source>%1, left blade: %2, %3, right blade: %4</source>
        <translation>%1：左のブレード %2；%3：右のブレード %4</translation>
    </message>
    <message>
        <source>left blade: %1</source>
        <translation>左のブレード：%1</translation>
    </message>
    <message>
        <source>right blade: %1</source>
        <translation>右のブレード：%1</translation>
    </message>
    <message>
        <source>%1 N and %2 N m, turned %3, the lip follows within %4 mm, pressure %5 kPa on average and %6 kPa at most (%7), %8 on its first, middle and last third along the incision</source>
        <translation>%1 N、%2 N m、回転 %3、創縁とのずれ %4 mm 以内、圧力は平均 %5 kPa、最大 %6 kPa（%7）、切開に沿う前・中・後の三分の一に %8</translation>
    </message>
    <message>
        <source>%1 N and %2 N m, turned %3, the lip follows within %4 mm</source>
        <translation>%1 N、%2 N m、回転 %3、創縁とのずれ %4 mm 以内</translation>
    </message>
    <message>
        <source>%1, %2 and %3 N</source>
        <translation>%1、%2、%3 N</translation>
    </message>
    <message>
        <source>%1 degrees (the end of its play)</source>
        <translation>%1 度（遊びの限界）</translation>
    </message>
    <message>
        <source>%1 degrees</source>
        <translation>%1 度</translation>
    </message>
    <message>
        <source>deep</source>
        <translation>深部</translation>
    </message>
    <message>
        <source>start</source>
        <translation>始点</translation>
    </message>
    <message>
        <source>end</source>
        <translation>終点</translation>
    </message>
    <message>
        <source>the frame has tilted by %1, and %2 N of its blade forces are not balanced</source>
        <translation>枠は %1 傾き、ブレードの力のうち %2 N が釣り合っていません</translation>
    </message>
    <message>
        <source>the left lip lies up to %1 mm (mean %2 mm) off the line of its %3, most %4 mm along the incision</source>
        <translation>左の創縁は%3の線から最大 %1 mm（平均 %2 mm）離れ、最も離れるのは切開に沿って %4 mm の所です</translation>
    </message>
    <message>
        <source>the right lip lies up to %1 mm (mean %2 mm) off the line of its %3, most %4 mm along the incision</source>
        <translation>右の創縁は%3の線から最大 %1 mm（平均 %2 mm）離れ、最も離れるのは切開に沿って %4 mm の所です</translation>
    </message>
    <message>
        <source>blade</source>
        <translation>ブレード</translation>
    </message>
    <message>
        <source>hooks</source>
        <translation>鉤</translation>
    </message>
    <message>
        <source>The shaded part of the plot is the part that these numbers cover.</source>
        <translation>図の陰影部分が、これらの数値の対象です。</translation>
    </message>
    <message>
        <source>largest strain, averaged over balls of %1 mm radius: %2</source>
        <translation>半径 %1 mm の球で平均した最大ひずみ：%2</translation>
    </message>
    <message>
        <source>%1 %2 % %3 mm along the incision, %4 mm beside it and %5 mm deep</source>
        <translation>%1 %2 %（切開に沿って %3 mm、横に %4 mm、深さ %5 mm）</translation>
    </message>
    <message>
        <source>%1 %2 % %3 mm before the start of the incision, %4 mm beside it and %5 mm deep</source>
        <translation>%1 %2 %（切開の始点の手前 %3 mm、横に %4 mm、深さ %5 mm）</translation>
    </message>
    <message>
        <source>%1 %2 % %3 mm beyond the end of the incision, %4 mm beside it and %5 mm deep</source>
        <translation>%1 %2 %（切開の終点の先 %3 mm、横に %4 mm、深さ %5 mm）</translation>
    </message>
    <message>
        <source>%1 % %2 mm along the incision, %3 mm beside it and %4 mm deep</source>
        <translation>%1 %（切開に沿って %2 mm、横に %3 mm、深さ %4 mm）</translation>
    </message>
    <message>
        <source>%1 % %2 mm before the start of the incision, %3 mm beside it and %4 mm deep</source>
        <translation>%1 %（切開の始点の手前 %2 mm、横に %3 mm、深さ %4 mm）</translation>
    </message>
    <message>
        <source>%1 % %2 mm beyond the end of the incision, %3 mm beside it and %4 mm deep</source>
        <translation>%1 %（切開の終点の先 %2 mm、横に %3 mm、深さ %4 mm）</translation>
    </message>
    <message>
        <source>skin may tear: %1, torn samples failed between %2 and %3 %</source>
        <translation>皮膚は裂けることがあります：%1。引き裂いた試料は %2 〜 %3 % で破断しました</translation>
    </message>
    <message>
        <source>skin would tear: %1, torn samples failed between %2 and %3 %</source>
        <translation>皮膚は裂けます：%1。引き裂いた試料は %2 〜 %3 % で破断しました</translation>
    </message>
    <message>
        <source>Force %1 N</source>
        <translation>力 %1 N</translation>
    </message>
    <message>
        <source>mesh: +- %1 N</source>
        <translation>格子：± %1 N</translation>
    </message>
    <message>
        <source>tissue values: %1 to %2 N</source>
        <translation>組織の値：%1 〜 %2 N</translation>
    </message>
    <message>
        <source>decided by %1</source>
        <translation>主に決めるもの：%1</translation>
    </message>
    <message>
        <source>decided by %1: one standard deviation.</source>
        <translation>主に決めるもの：%1（標準偏差ひとつ分）。</translation>
    </message>
    <message>
        <source>tissue values: force %1 to %2 N, opening %3 to %4 mm</source>
        <translation>組織の値：力 %1 〜 %2 N、開口 %3 〜 %4 mm</translation>
    </message>
    <message>
        <source>%1 (times %2: little is seen)</source>
        <translation>%1（× %2：わずかしか見えません）</translation>
    </message>
    <message>
        <source>A plus is better and a minus is worse than as planned, by more than both errors together.</source>
        <translation>プラスは計画より良く、マイナスは悪いことを示します（両方の誤差を合わせた以上の差）。</translation>
    </message>
    <message>
        <source>In the window B adds these approaches, and Shift+P plans them.</source>
        <translation>ウィンドウでは B でこれらのアプローチを追加し、Shift+P で計画します。</translation>
    </message>
    <message>
        <source>%1: one space higher: %2; one space lower: %3; 20 mm forwards: %4; 20 mm backwards: %5.</source>
        <translation>%1：一肋間上：%2、一肋間下：%3、前へ 20 mm：%4、後ろへ 20 mm：%5。</translation>
    </message>
    <message>
        <source>not planned</source>
        <translation>未計画</translation>
    </message>
    <message>
        <source>the space leaves room for %1 mm only</source>
        <translation>肋間の余地は %1 mm だけです</translation>
    </message>
    <message>
        <source>the space leaves no room that way</source>
        <translation>肋間にその方向の余地がありません</translation>
    </message>
    <message>
        <source>It is centred where the space comes nearest to the target (%1 mm), as far as the shoulder blade, the back muscles and the ribs' ends allow.</source>
        <translation>肩甲骨、背筋、肋骨端が許す限り、肋間が標的に最も近づく所（%1 mm）を中心とします。</translation>
    </message>
    <message>
        <source>The target's centre lies %1 mm from the nearest point of the incision.</source>
        <translation>標的の中心は切開の最も近い点から %1 mm にあります。</translation>
    </message>
    <message>
        <source>Tissue without a label is not drawn and hides nothing.</source>
        <translation>ラベルのない組織は描かれず、何も隠しません。</translation>
    </message>
    <message>
        <source>soft tissue only</source>
        <translation>軟部組織のみ</translation>
    </message>
    <message>
        <source>left_blade: %1, right_blade: %2</source>
        <translation>左のブレード：%1、右のブレード：%2</translation>
    </message>
    <message>
        <source>left blade to %1</source>
        <translation>左のブレードと%1</translation>
    </message>
    <message>
        <source>right blade to %1</source>
        <translation>右のブレードと%1</translation>
    </message>
    <message>
        <source>The plan is made: forces by hand are matched to it once the wound is opened as planned</source>
        <translation>計画ができました。計画どおりに開創すると、手動での力を計画に合わせます</translation>
    </message>
    <message>
        <source>The new plan says no force: forces by hand are not matched</source>
        <translation>新しい計画には力がありません。手動での力は合わせません</translation>
    </message>
    <message>
        <source>%1 sunk in</source>
        <translation>%1 沈み込み</translation>
    </message>
    <message>
        <source>cut over %1 mm</source>
        <translation>%1 mm にわたって切開しました</translation>
    </message>
    <message>
        <source>surfaces that overlap by up to %1 mm at rest keep this overlap</source>
        <translation>静止時に最大 %1 mm 重なる面は、その重なりを保ちます</translation>
    </message>
    <message>
        <source>largest strain, averaged over balls of %1 mm radius: %2 %3 % %4 mm along the incision, %5 mm beside it and %6 mm deep</source>
        <translation>半径 %1 mm の球で平均した最大ひずみ：%2 %3 %（切開に沿って %4 mm、横に %5 mm、深さ %6 mm）</translation>
    </message>
    <message>
        <source>largest strain, averaged over balls of %1 mm radius: %2 %3 % %4 mm before the start of the incision, %5 mm beside it and %6 mm deep</source>
        <translation>半径 %1 mm の球で平均した最大ひずみ：%2 %3 %（切開の始点の手前 %4 mm、横に %5 mm、深さ %6 mm）</translation>
    </message>
    <message>
        <source>largest strain, averaged over balls of %1 mm radius: %2 %3 % %4 mm beyond the end of the incision, %5 mm beside it and %6 mm deep</source>
        <translation>半径 %1 mm の球で平均した最大ひずみ：%2 %3 %（切開の終点の先 %4 mm、横に %5 mm、深さ %6 mm）</translation>
    </message>
    <message>
        <source>building the model of the wall</source>
        <translation>体壁のモデルを作成中</translation>
    </message>
    <message>
        <source>finding how much of the wall moves</source>
        <translation>体壁の動く範囲を調べています</translation>
    </message>
    <message>
        <source>cutting</source>
        <translation>切開中</translation>
    </message>
    <message>
        <source>removing tissue</source>
        <translation>組織を切除中</translation>
    </message>
    <message>
        <source>restoring the cuts</source>
        <translation>切開を復元中</translation>
    </message>
    <message>
        <source>letting the wound gape</source>
        <translation>創の開きを計算中</translation>
    </message>
    <message>
        <source>opening the wound</source>
        <translation>開創中</translation>
    </message>
    <message>
        <source>opening: first estimate</source>
        <translation>開創中（最初の見積もり）</translation>
    </message>
    <message>
        <source>opening: the retractor settles</source>
        <translation>開創中（開創器の釣り合い）</translation>
    </message>
    <message>
        <source>opening: tissues that touch</source>
        <translation>開創中（組織どうしの接触）</translation>
    </message>
    <message>
        <source>opening: without hooks</source>
        <translation>開創中（鉤なし）</translation>
    </message>
    <message>
        <source>opening: whole wall</source>
        <translation>開創中（体壁全体）</translation>
    </message>
    <message>
        <source>opening less, until no bone breaks</source>
        <translation>骨が折れない開創幅を計算中</translation>
    </message>
    <message>
        <source>looking through the wound</source>
        <translation>創を通した視野を計算中</translation>
    </message>
    <message>
        <source>looking with organs higher</source>
        <translation>創を通した視野を計算中（臓器が頭側にある場合）</translation>
    </message>
    <message>
        <source>looking past other lung volumes</source>
        <translation>創を通した視野を計算中（肺の容積を変えた場合）</translation>
    </message>
    <message>
        <source>looking with the patient turned</source>
        <translation>患者の体位を変えて見え方を計算中</translation>
    </message>
    <message>
        <source>reaching in with instruments</source>
        <translation>器具の到達を計算中</translation>
    </message>
    <message>
        <source>estimating the error</source>
        <translation>誤差を見積もり中</translation>
    </message>
    <message>
        <source>drawing what lies round the wound</source>
        <translation>創の周囲を描画中</translation>
    </message>
    <message>
        <source>finding where a finger can go</source>
        <translation>指の届く範囲を調べています</translation>
    </message>
    <message>
        <source>drawing</source>
        <translation>描画中</translation>
    </message>
    <message>
        <source>drawing the movie</source>
        <translation>動画を描画中</translation>
    </message>
    <message>
        <source>writing the report</source>
        <translation>報告書を作成中</translation>
    </message>
    <message>
        <source>trying incisions</source>
        <translation>切開を試しています</translation>
    </message>
    <message>
        <source>making the organ palpable</source>
        <translation>臓器を触診できるようにしています</translation>
    </message>
    <message>
        <source>building the model of the wall (about %1 s)</source>
        <translation>体壁のモデルを作成中（約 %1 秒）</translation>
    </message>
    <message>
        <source>Preparing the tissue: %1</source>
        <translation>組織を準備しています：%1</translation>
    </message>
    <message>
        <source>making the organ palpable %1 %</source>
        <translation>臓器を触診できるようにしています %1 %</translation>
    </message>
    <message>
        <source>restoring the cuts %1 %</source>
        <translation>切開を復元中 %1 %</translation>
    </message>
    <message>
        <source>finding where a finger can go %1 %</source>
        <translation>指の届く範囲を調べています %1 %</translation>
    </message>
    <message>
        <source>Both eyes with a lamp see %1 %.</source>
        <translation>照明を使う両眼には %1 % が見えます。</translation>
    </message>
    <message>
        <source>Two instruments reach %1 %.</source>
        <translation>二本の器械は %1 % に届きます。</translation>
    </message>
    <message>
        <source>A finger touches %1 %.</source>
        <translation>指は %1 % に触れます。</translation>
    </message>
    <message>
        <source>A finger ends %1 mm before the %2.</source>
        <translation>指は%2の %1 mm 手前で止まります。</translation>
    </message>
    <message>
        <source>What stays hidden is its %1 part.</source>
        <translation>隠れたままなのは%1の部分です。</translation>
    </message>
    <message>
        <source>superior</source>
        <translation>頭側</translation>
    </message>
    <message>
        <source>inferior</source>
        <translation>尾側</translation>
    </message>
    <message>
        <source>Organs hide the %1 even with the wall removed.</source>
        <translation>胸壁がなくても、臓器が%1を隠します。</translation>
    </message>
    <message>
        <source>No eye sees the %1 through the opening at less than %2 degrees of incidence.</source>
        <translation>入射角 %2 度未満で開口部から%1を見る位置はありません。</translation>
    </message>
    <message>
        <source>No angle to the valve: %1.</source>
        <translation>弁に対する角度はありません：%1。</translation>
    </message>
    <message>
        <source>The opening lies %1 mm from the annulus, %2 degrees off the valve's axis; the best eye looks along it at %3 degrees.</source>
        <translation>開口部は弁輪から %1 mm、弁の軸から %2 度の所にあります。最良の眼は軸に対して %3 度で見ます。</translation>
    </message>
    <message>
        <source>The opening lies %1 mm from the annulus, %2 degrees off the valve's axis.</source>
        <translation>開口部は弁輪から %1 mm、弁の軸から %2 度の所にあります。</translation>
    </message>
    <message>
        <source>No bone stands in the line of sight.</source>
        <translation>視線に骨はありません。</translation>
    </message>
    <message>
        <source>Mind that %1.</source>
        <translation>注意：%1。</translation>
    </message>
    <message>
        <source>the hole of the removed skin (%1 cm2 at rest) is not part of the opening</source>
        <translation>切除した皮膚の穴（静止時 %1 cm2）は開口に含みません</translation>
    </message>
    <message>
        <source>The other shares of the target have no error bars of their own: they are at least as uncertain as the opening, whose bar is %1 of its width.</source>
        <translation>標的のほかの割合には固有の誤差がありません。少なくとも開口部と同じ程度に不確かで、その誤差は幅の %1 です。</translation>
    </message>
    <message>
        <source>Largest opening without a fracture (estimate)</source>
        <translation>骨折しない最大の開創（推定）</translation>
    </message>
    <message>
        <source>%1 mm and %2 N: beyond %3 mm and %4 N tissue ruptured in half of %5 retractions with a rib spreader (%6)</source>
        <translation>%1 mm、%2 N：%3 mm と %4 N を超えると、開胸器による %5 回の開創の半数で組織が裂けました（%6）</translation>
    </message>
    <message>
        <source>ten-node elements at bone, and at lips unless blades bear on cut bone, four-node elements elsewhere, Poisson's ratios at most %1</source>
        <translation>骨と、ブレードが切断骨に当たらない創縁では十節点要素、ほかは四節点要素、ポアソン比は %1 以下</translation>
    </message>
    <message>
        <source>corotational</source>
        <translation>共回転</translation>
    </message>
    <message>
        <source>neo-Hookean</source>
        <translation>ネオフック</translation>
    </message>
    <message>
        <source>solved as %1</source>
        <translation>解法：%1</translation>
    </message>
    <message>
        <source>a draft, solved as %1</source>
        <translation>下書き、解法：%1</translation>
    </message>
    <message>
        <source>relative residual %1</source>
        <translation>相対残差 %1</translation>
    </message>
    <message>
        <source>%1, left blade: %2</source>
        <translation>%1、左のブレード：%2</translation>
    </message>
    <message>
        <source>%1, right blade: %2</source>
        <translation>%1、右のブレード：%2</translation>
    </message>
    <message>
        <source>Hooks: %1</source>
        <translation>鉤：%1</translation>
    </message>
    <message>
        <source>Blades: %1</source>
        <translation>ブレード：%1</translation>
    </message>
    <message>
        <source>muscle with its fasciae under retraction</source>
        <translation>開創時の筋と筋膜</translation>
    </message>
    <message>
        <source>shear wave to the first slope in tension, %1</source>
        <translation>せん断波から引張の初期勾配まで、%1</translation>
    </message>
    <message>
        <source>%1 to %2 across the fibres, %3</source>
        <translation>線維を横切る方向に %1 〜 %2、%3</translation>
    </message>
    <message>
        <source>widened, ours</source>
        <translation>本プログラムで広げた範囲</translation>
    </message>
    <message>
        <source>substance %1 to %2 MPa, with perichondrium, %3</source>
        <translation>実質 %1 〜 %2 MPa、軟骨膜を含む、%3</translation>
    </message>
    <message>
        <source>by the patient's CT, see bone_stiffness</source>
        <translation>患者の CT による。bone_stiffness を参照</translation>
    </message>
    <message>
        <source>whole ribs in bending, %1</source>
        <translation>肋骨全体の曲げ、%1</translation>
    </message>
    <message>
        <source>turns by %1 to %2 degrees, %3</source>
        <translation>%1 〜 %2 度回る、%3</translation>
    </message>
    <message>
        <source>small to moderate strain</source>
        <translation>小 〜 中程度のひずみ</translation>
    </message>
    <message>
        <source>a factor of %1 to either side, ours</source>
        <translation>上下に %1 倍、本プログラムの仮定</translation>
    </message>
    <message>
        <source>cortex of %1 GPa [%2] over %3 % of the section, median of %4 sections in the CT</source>
        <translation>断面の %3 % が皮質骨（%1 GPa [%2]）、CT の %4 断面の中央値</translation>
    </message>
    <message>
        <source>%1 MPa (%2) times %3 for the perichondrium [%4] times %5 for the calcified share of %6 % [%7]</source>
        <translation>%1 MPa（%2）に軟骨膜の %3 倍 [%4]、石灰化 %6 % の %5 倍を掛けた値 [%7]</translation>
    </message>
    <message>
        <source>The model holds the whole wall in the image.</source>
        <translation>モデルは画像内の体壁のすべてを含みます。</translation>
    </message>
    <message>
        <source>The model holds the wall within %1 mm of the incision (given).</source>
        <translation>モデルは切開から %1 mm 以内の体壁を含みます（指定）。</translation>
    </message>
    <message>
        <source>A larger region needs more memory than there is.</source>
        <translation>より広い範囲にはメモリが足りません。</translation>
    </message>
    <message>
        <source>A larger region gave no answer: %1.</source>
        <translation>より広い範囲では答えが得られませんでした：%1。</translation>
    </message>
    <message>
        <source>By drafts, the wall beyond changes the force more than twofold.</source>
        <translation>下書きでは、その外の壁で力が二倍以上変わります。</translation>
    </message>
    <message>
        <source>By drafts, the wall beyond changes the force by %1 %.</source>
        <translation>下書きでは、その外の壁で力が %1 % 変わります。</translation>
    </message>
    <message>
        <source>contact: %1 points touch, with %2 N in total and a penetration of at most %3 mm</source>
        <translation>接触：%1 点が触れ、合計 %2 N、食い込みは最大 %3 mm</translation>
    </message>
    <message>
        <source>contact: nothing touches</source>
        <translation>接触：何も触れません</translation>
    </message>
    <message>
        <source>Time: %1.</source>
        <translation>計算時間：%1。</translation>
    </message>
    <message>
        <source>mesh</source>
        <translation>メッシュ</translation>
    </message>
    <message>
        <source>open</source>
        <translation>開創</translation>
    </message>
    <message>
        <source>expose</source>
        <translation>術野</translation>
    </message>
    <message>
        <source>estimate error</source>
        <translation>誤差の推定</translation>
    </message>
    <message>
        <source>organs higher</source>
        <translation>臓器の頭側移動</translation>
    </message>
    <message>
        <source>tissue values</source>
        <translation>組織値</translation>
    </message>
    <message>
        <source>strain and bones</source>
        <translation>ひずみと骨</translation>
    </message>
    <message>
        <source>render</source>
        <translation>描画</translation>
    </message>
    <message>
        <source>Rib %1 on the left would break in its %2 part, %3 mm from the spine, from an opening of about %4 mm on (%5 N m; tested ribs broke at about %6 N m).</source>
        <translation>左第 %1 肋骨は、脊椎から %3 mm の%2部で、開創およそ %4 mm から折れる見込みです（%5 N m、試験では肋骨はおよそ %6 N m で折れました）。</translation>
    </message>
    <message>
        <source>Rib %1 on the right would break in its %2 part, %3 mm from the spine, from an opening of about %4 mm on (%5 N m; tested ribs broke at about %6 N m).</source>
        <translation>右第 %1 肋骨は、脊椎から %3 mm の%2部で、開創およそ %4 mm から折れる見込みです（%5 N m、試験では肋骨はおよそ %6 N m で折れました）。</translation>
    </message>
    <message>
        <source>The largest opening without a fracture is about %1 mm (estimate).</source>
        <translation>骨折しない最大の開創はおよそ %1 mm です（推定）。</translation>
    </message>
    <message>
        <source>%1, by retractor %2</source>
        <translation>%1、retractor %2 による</translation>
    </message>
    <message>
        <source>%1, opened by a %2</source>
        <translation>%1、%2で開く</translation>
    </message>
    <message>
        <source>%1, opened %2 mm</source>
        <translation>%1、%2 mm 開く</translation>
    </message>
    <message>
        <source>range %1 - %2 MPa, %3; middle value</source>
        <translation>範囲 %1 〜 %2 MPa、%3。中央の値</translation>
    </message>
    <message>
        <source>range %1 - %2 MPa, %3</source>
        <translation>範囲 %1 〜 %2 MPa、%3</translation>
    </message>
    <message>
        <source>middle value</source>
        <translation>中央の値</translation>
    </message>
    <message>
        <source>%1: in-plane stretch of tens of per cent; %2 MPa at small strain (shear wave), %3 MPa in tension to failure</source>
        <translation>%1：面内の数十 % の伸び。小ひずみでは %2 MPa（せん断波）、破断までの引張では %3 MPa</translation>
    </message>
    <message>
        <source>%1: relaxed, across the fibres, light load; %2 MPa at %3 N</source>
        <translation>%1：弛緩時、線維を横切る方向、軽い荷重。%3 N で %2 MPa</translation>
    </message>
    <message>
        <source>%1: whole ribs in bending, homogenised over cortex and marrow, %2 - %3 MPa; geometric mean</source>
        <translation>%1：肋骨全体の曲げ、皮質と髄を均質化、%2 〜 %3 MPa。幾何平均</translation>
    </message>
    <message>
        <source>costal cartilage, range %1 - %2 MPa, small strain: %3 MPa times %4 for the perichondrium (%5)</source>
        <translation>肋軟骨、範囲 %1 〜 %2 MPa、小ひずみ：%3 MPa に軟骨膜の %4 倍を掛けた値（%5）</translation>
    </message>
    <message>
        <source>aortic wall at pulse strain; %1 MPa young, %2 MPa old from in-vivo stretch (%3)</source>
        <translation>脈動のひずみでの大動脈壁。生体内の伸びから若年 %1 MPa、高齢 %2 MPa（%3）</translation>
    </message>
    <message>
        <source>sclerotic aortic wall at pulse strain, three times the normal wall</source>
        <translation>脈動のひずみでの硬化した大動脈壁、正常壁の三倍</translation>
    </message>
    <message>
        <source>passive myocardium, small strain, order of magnitude: shear modulus %1 - %2 kPa</source>
        <translation>受動的な心筋、小ひずみ、桁の目安：せん断弾性率 %1 〜 %2 kPa</translation>
    </message>
    <message>
        <source>inflated parenchyma, small strain, order of magnitude: %1 - %2 kPa</source>
        <translation>含気した肺実質、小ひずみ、桁の目安：%1 〜 %2 kPa</translation>
    </message>
    <message>
        <source>%1: shear modulus %2 kPa, small strain (elastography)</source>
        <translation>%1：せん断弾性率 %2 kPa、小ひずみ（エラストグラフィ）</translation>
    </message>
    <message>
        <source>%1 mm and more</source>
        <translation>%1 mm 以上</translation>
    </message>
    <message>
        <source>left lung deflated</source>
        <translation>虚脱した左肺</translation>
    </message>
    <message>
        <source>right lung deflated</source>
        <translation>虚脱した右肺</translation>
    </message>
    <message>
        <source>%1: Strain</source>
        <translation>%1：ひずみ</translation>
    </message>
    <message>
        <source>%1: Pressure of the blades</source>
        <translation>%1：ブレードの圧力</translation>
    </message>
    <message>
        <source>%1: Distance to structures at risk</source>
        <translation>%1：危険構造までの距離</translation>
    </message>
    <message>
        <source>%1: How much of the view shows each part of the target</source>
        <translation>%1：標的の各部が視野に占める割合</translation>
    </message>
    <message>
        <source>%1: Where the eye sees how much</source>
        <translation>%1：どこから見るとどれだけ見えるか</translation>
    </message>
    <message>
        <source>%1: What a finger and two instruments reach</source>
        <translation>%1：指と二本の器械が届く所</translation>
    </message>
    <message>
        <source>NOT IN EQUILIBRIUM: its numbers are not shown</source>
        <translation>釣り合っていません：数値は表示しません</translation>
    </message>
    <message>
        <source>NOT USABLE: its numbers are not shown</source>
        <translation>使用不可：数値は表示しません</translation>
    </message>
    <message>
        <source>target: %1</source>
        <translation>標的：%1</translation>
    </message>
    <message>
        <source>seen by the best eye</source>
        <translation>最良の眼に見える割合</translation>
    </message>
    <message>
        <source>  with two eyes and a lamp</source>
        <translation>  照明と両眼で</translation>
    </message>
    <message>
        <source>  reached by two instruments</source>
        <translation>  二本の器械が届く割合</translation>
    </message>
    <message>
        <source>working distance</source>
        <translation>作業距離</translation>
    </message>
    <message>
        <source>incision</source>
        <translation>切開</translation>
    </message>
    <message>
        <source>retractor force, one side</source>
        <translation>開創器の力（片側）</translation>
    </message>
    <message>
        <source>hook force, one side</source>
        <translation>鉤の力（片側）</translation>
    </message>
    <message>
        <source>hooks that yield</source>
        <translation>滑る鉤</translation>
    </message>
    <message>
        <source>bone in sight</source>
        <translation>視線にある骨</translation>
    </message>
    <message>
        <source>%1 and %2 more</source>
        <translation>%1とほか %2</translation>
    </message>
    <message>
        <source>along the incision: a flat section; the cut curves up to %1 mm out of it</source>
        <translation>切開に沿う平面断面。切開は最大 %1 mm 外れて曲がります</translation>
    </message>
    <message>
        <source>left blade, largest</source>
        <translation>左のブレード、最大</translation>
    </message>
    <message>
        <source>right blade, largest</source>
        <translation>右のブレード、最大</translation>
    </message>
    <message>
        <source>nearest to the steel</source>
        <translation>器械に最も近いもの</translation>
    </message>
    <message>
        <source>nearest to the cut, at rest</source>
        <translation>切開に最も近いもの（静止時）</translation>
    </message>
    <message>
        <source>none within %1 mm</source>
        <translation>%1 mm 以内になし</translation>
    </message>
    <message>
        <source>below %1 mm</source>
        <translation>%1 mm 未満</translation>
    </message>
    <message>
        <source>below %1 kPa</source>
        <translation>%1 kPa 未満</translation>
    </message>
    <message>
        <source>below %1 %</source>
        <translation>%1 % 未満</translation>
    </message>
    <message>
        <source>%1 or more mm</source>
        <translation>%1 mm 以上</translation>
    </message>
    <message>
        <source>%1 or more kPa</source>
        <translation>%1 kPa 以上</translation>
    </message>
    <message>
        <source>%1 or more %</source>
        <translation>%1 % 以上</translation>
    </message>
    <message>
        <source>The blades bear on soft tissue only, on no bone.</source>
        <translation>ブレードは軟部組織だけに当たり、骨には当たりません。</translation>
    </message>
    <message>
        <source>The incision divides cartilage: %1.</source>
        <translation>切開線が軟骨を切離します: %1。</translation>
    </message>
    <message>
        <source>The mediastinum is held aside in one piece. Vessels in it without a label are not drawn, and no distance to them is kept.</source>
        <translation>縦隔は一塊として圧排されています。その中のラベルのない血管は描かれず、距離も保たれません。</translation>
    </message>
    <message>
        <source>What the retractor or the hooks are set to. The skin's edge opens more or less than they do.</source>
        <translation>開創器またはフックの設定値。皮膚縁の開きはこれと異なります。</translation>
    </message>
    <message>
        <source>The sternum, along and across</source>
        <translation>胸骨（縦と横）</translation>
    </message>
    <message>
        <source>All tissue under the incision</source>
        <translation>切開下のすべての組織</translation>
    </message>
    <message>
        <source>Soft tissue and the sternum under the incision</source>
        <translation>切開下の軟部組織と胸骨</translation>
    </message>
    <message>
        <source>What the knife or the saw goes through.</source>
        <translation>メスまたは鋸が切離するもの。</translation>
    </message>
    <message>
        <source>not usable</source>
        <translation>使用不可</translation>
    </message>
    <message>
        <source>not usable: %1</source>
        <translation>使用不可：%1</translation>
    </message>
    <message>
        <source>The numbers are under Technical.</source>
        <translation>数値は「技術情報」にあります。</translation>
    </message>
    <message>
        <source>%1: the numbers are not to be used.</source>
        <translation>%1：数値は使用できません。</translation>
    </message>
    <message>
        <source>The incision crosses bone that stays whole: %1.</source>
        <translation>切開線が切離されない骨を横切っています: %1。</translation>
    </message>
    <message>
        <source>The %1 bears on soft tissue only, on no bone.</source>
        <translation>%1は軟部組織だけに当たり、骨には当たりません。</translation>
    </message>
    <message>
        <source>Stereo</source>
        <translation>立体表示</translation>
    </message>
    <message>
        <source>Off</source>
        <translation>オフ</translation>
    </message>
    <message>
        <source>Red and cyan</source>
        <translation>赤青メガネ</translation>
    </message>
    <message>
        <source>Side by side</source>
        <translation>左右に並べる</translation>
    </message>
    <message>
        <source>Lines</source>
        <translation>走査線ごと</translation>
    </message>
    <message>
        <source>Show scenes in space to one eye</source>
        <translation>立体の画面を片目用に表示します</translation>
    </message>
    <message>
        <source>For coloured glasses, the red one before the left eye</source>
        <translation>色メガネ用。赤いレンズを左目に当てます</translation>
    </message>
    <message>
        <source>For a 3D monitor that takes both pictures beside each other; use the full screen</source>
        <translation>左右の画像を並べて受ける 3D モニタ用。全画面で使います</translation>
    </message>
    <message>
        <source>For a 3D monitor whose lines belong to the left and the right eye in turn</source>
        <translation>走査線が左右の眼に交互に属する 3D モニタ用</translation>
    </message>
    <message>
        <source>left lung, deflated</source>
        <translation>虚脱した左肺</translation>
    </message>
    <message>
        <source>right lung, deflated</source>
        <translation>虚脱した右肺</translation>
    </message>
    <message>
        <source>coronary target</source>
        <translation>冠動脈の標的</translation>
    </message>
    <message>
        <source>gape</source>
        <translation>創の開き</translation>
    </message>
    <message>
        <source>estimate condensed region</source>
        <translation>縮約領域の誤差</translation>
    </message>
    <message>
        <source>compare with nonlinear wall</source>
        <translation>非線形の壁との比較</translation>
    </message>
    <message>
        <source>score by rays, before planning, of an incision whose middle is there</source>
        <translation>そこを中央とする切開の、計画前の光線による点数</translation>
    </message>
    <message>
        <source>shows too little for a proposal</source>
        <translation>見える割合が提案には小さすぎる</translation>
    </message>
    <message>
        <source>too near a structure at risk</source>
        <translation>危険構造に近すぎる</translation>
    </message>
    <message>
        <source>not tried</source>
        <translation>試していない</translation>
    </message>
    <message>
        <source>no incision could be proposed</source>
        <translation>提案できる切開はありません</translation>
    </message>
    <message>
        <source>from the patient's right</source>
        <translation>患者の右から</translation>
    </message>
    <message>
        <source>from the patient's left</source>
        <translation>患者の左から</translation>
    </message>
    <message>
        <source>from behind</source>
        <translation>背中側から</translation>
    </message>
    <message>
        <source>Off its line: lip at the %1</source>
        <translation>%1の創縁のずれ</translation>
    </message>
    <message>
        <source>Each side by</source>
        <translation>片側ずつ</translation>
    </message>
    <message>
        <source>the lip at the %1 lies up to %2 mm (mean %3 mm) off the line of its %4, most %5 mm along the incision</source>
        <translation>%1の創縁は%4の線から最大 %2 mm（平均 %3 mm）離れ、最も離れるのは切開に沿って %5 mm の所です</translation>
    </message>
    <message>
        <source>lip at the %1</source>
        <translation>%1の創縁</translation>
    </message>
    <message>
        <source>Force of the %1</source>
        <translation>%1の力</translation>
    </message>
    <message>
        <source>The incision is where it was.</source>
        <translation>切開はもとのままです。</translation>
    </message>
    <message>
        <source>upper blade: %1</source>
        <translation>上のブレード：%1</translation>
    </message>
    <message>
        <source>upper blade to %1</source>
        <translation>上のブレードと%1</translation>
    </message>
    <message>
        <source>%1, upper blade: %2</source>
        <translation>%1、上のブレード：%2</translation>
    </message>
    <message>
        <source>upper blade, largest</source>
        <translation>上のブレード、最大</translation>
    </message>
    <message>
        <source>lower blade: %1</source>
        <translation>下のブレード：%1</translation>
    </message>
    <message>
        <source>lower blade to %1</source>
        <translation>下のブレードと%1</translation>
    </message>
    <message>
        <source>%1, lower blade: %2</source>
        <translation>%1、下のブレード：%2</translation>
    </message>
    <message>
        <source>lower blade, largest</source>
        <translation>下のブレード、最大</translation>
    </message>
    <message>
        <source>front blade: %1</source>
        <translation>前のブレード：%1</translation>
    </message>
    <message>
        <source>front blade to %1</source>
        <translation>前のブレードと%1</translation>
    </message>
    <message>
        <source>%1, front blade: %2</source>
        <translation>%1、前のブレード：%2</translation>
    </message>
    <message>
        <source>front blade, largest</source>
        <translation>前のブレード、最大</translation>
    </message>
    <message>
        <source>back blade: %1</source>
        <translation>後ろのブレード：%1</translation>
    </message>
    <message>
        <source>back blade to %1</source>
        <translation>後ろのブレードと%1</translation>
    </message>
    <message>
        <source>%1, back blade: %2</source>
        <translation>%1、後ろのブレード：%2</translation>
    </message>
    <message>
        <source>back blade, largest</source>
        <translation>後ろのブレード、最大</translation>
    </message>
    <message>
        <source>%1, upper blade: %2, %3, lower blade: %4</source>
        <translation>%1：上のブレード %2；%3：下のブレード %4</translation>
    </message>
    <message>
        <source>%1, lower blade: %2, %3, upper blade: %4</source>
        <translation>%1：下のブレード %2；%3：上のブレード %4</translation>
    </message>
    <message>
        <source>%1, front blade: %2, %3, back blade: %4</source>
        <translation>%1：前のブレード %2；%3：後ろのブレード %4</translation>
    </message>
    <message>
        <source>%1, back blade: %2, %3, front blade: %4</source>
        <translation>%1：後ろのブレード %2；%3：前のブレード %4</translation>
    </message>
    <message>
        <source>... after %1 minutes</source>
        <translation>… %1 分後</translation>
    </message>
    <message>
        <source>ribs %1 to %2 GPa (%3 of %4 by their sections in the CT)</source>
        <translation>肋骨 %1〜%2 GPa（%4 本中 %3 本は CT の断面による）</translation>
    </message>
    <message>
        <source>ribs %1 GPa (%2 of %3 by their sections in the CT)</source>
        <translation>肋骨 %1 GPa（%3 本中 %2 本は CT の断面による）</translation>
    </message>
    <message>
        <source>More tools</source>
        <translation>ほかの道具</translation>
    </message>
    <message>
        <source>%1, right blade: %2, %3, left blade: %4</source>
        <translation>%1：右のブレード %2；%3：左のブレード %4</translation>
    </message>
    <message>
        <source>right_blade: %1, left_blade: %2</source>
        <translation>右のブレード：%1、左のブレード：%2</translation>
    </message>
    <message>
        <source>upper_blade: %1, lower_blade: %2</source>
        <translation>上のブレード：%1、下のブレード：%2</translation>
    </message>
    <message>
        <source>lower_blade: %1, upper_blade: %2</source>
        <translation>下のブレード：%1、上のブレード：%2</translation>
    </message>
    <message>
        <source>front_blade: %1, back_blade: %2</source>
        <translation>前のブレード：%1、後ろのブレード：%2</translation>
    </message>
    <message>
        <source>back_blade: %1, front_blade: %2</source>
        <translation>後ろのブレード：%1、前のブレード：%2</translation>
    </message>
</context>
</TS>
