//! Other files, opened from the page.

use super::*;

/// Small files of a grid, of points, of a mesh of cells and of an adaptive grid; returns their names.
fn small_files(folder: &std::path::Path) -> [&'static str; 4] {
    let write = |name: &str, text: String| std::fs::write(folder.join(name), text).unwrap();
    std::fs::write(folder.join("grid.nrrd"), common::nrrd(1.0)).unwrap();
    // Points on a lattice, with a radius and a value each.
    let rows: String = (0..64).map(|i| format!("{},{},{},1.2,{}\n", i % 4, i / 4 % 4, i / 16, 1 + i % 5)).collect();
    write("points.csv", format!("x,y,z,h,Temperature\n{rows}"));
    // Two tetrahedra on a common face.
    let mesh = "# vtk DataFile Version 3.0\ncells\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n0 0 0  2 0 0  0 2 0  0 0 2  2 2 2\n\
                CELLS 2 10\n4 0 1 2 3\n4 1 2 3 4\nCELL_TYPES 2\n10 10\nPOINT_DATA 5\nSCALARS f float 1\nLOOKUP_TABLE default\n0 1 2 3 4\n";
    write("cells.vtk", mesh.to_owned());
    // 4×4×2 cells, of which the half on the left is refined by two.
    write(
        "adaptive.vthb",
        "<VTKFile type=\"vtkOverlappingAMR\" version=\"1.1\"><vtkOverlappingAMR origin=\"0 0 0\" grid_description=\"XYZ\">\n\
         <Block level=\"0\" spacing=\"1 1 1\"><DataSet index=\"0\" amr_box=\"0 3 0 3 0 1\" file=\"parts/0.vti\"/></Block>\n\
         <Block level=\"1\" spacing=\"0.5 0.5 0.5\"><DataSet index=\"0\" amr_box=\"0 3 0 7 0 3\" file=\"parts/1.vti\"/></Block>\n\
         </vtkOverlappingAMR></VTKFile>\n"
            .to_owned(),
    );
    std::fs::create_dir(folder.join("parts")).unwrap();
    for (name, spacing, n) in [("parts/0.vti", 1.0, [4, 4, 2]), ("parts/1.vti", 0.5, [4, 8, 4])] {
        let count = n[0] * n[1] * n[2];
        let values: String =
            (0..count).map(|i| format!("{} ", spacing * (i % n[0]) as f64 + (i / n[0] % n[1]) as f64)).collect();
        let extent = format!("0 {} 0 {} 0 {}", n[0], n[1], n[2]);
        write(
            name,
            format!(
                "<VTKFile type=\"ImageData\" version=\"1.0\"><ImageData WholeExtent=\"{extent}\" Origin=\"0 0 0\" Spacing=\"{spacing} {spacing} {spacing}\">\
                 <Piece Extent=\"{extent}\"><PointData/><CellData><DataArray type=\"Float64\" Name=\"f\">{values}</DataArray></CellData></Piece></ImageData></VTKFile>\n"
            ),
        );
    }
    ["grid.nrrd", "points.csv", "cells.vtk", "adaptive.vthb"]
}

#[test]
fn any_kind_of_volume_is_opened_from_the_page_and_undone() {
    let Some(mut browser) = Browser::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let names = small_files(folder.path());
    let running = Running::opening(document("blobs", 16, [64, 64]), Some(folder.path()), 1 << 20);
    browser.open(&format!("http://{}/{}/", running.address, running.token), SIZE, "dark");
    rest(&mut browser);
    browser.wait("window.vr.open.listing?.files.length === 6");
    let title = |browser: &mut Browser| browser.value("document.getElementById('title').textContent");
    let slices =
        "window.vr.slices.views.every((v) => v.slice && !v.waits && v.slice.values.some((n) => !Number.isNaN(n)))";
    browser.value("document.getElementById('slices-toggle').click()");
    browser.wait(slices);
    for name in names {
        // By its path; the picture at rest is that of the saved scene, which names the file.
        let before = picture(&mut browser);
        browser.value(&format!(
            "(() => {{ document.getElementById('open-path').value = {name:?}; document.getElementById('open-form').requestSubmit(); }})()"
        ));
        browser.wait(&format!("document.getElementById('title').textContent === {name:?}"));
        settled(&mut browser, before);
        browser.value("window.vr.send({ kind: 'automatic-look' })");
        let before = picture(&mut browser);
        settled(&mut browser, before);
        assert_truth(&mut browser);
        // Slices are of the new volume, and so is the curve.
        browser.wait(slices);
        let same = "window.vr.slices.views.map((v) => { const { size: [w, h], values, corner, right, down } = v.slice; \
                    const i = values.findIndex((n) => !Number.isNaN(n)); const [s, t] = [((i % w) + 0.5) / w, (Math.floor(i / w) + 0.5) / h]; \
                    const [x, y, z] = corner.map((c, k) => c + right[k] * s + down[k] * t); \
                    return fetch(`place?${new URLSearchParams({ x, y, z })}`).then((a) => a.json()).then((p) => [values[i], Math.fround(p.value)]); })";
        let pairs = browser.value(&format!("Promise.all({same})"));
        for pair in pairs.as_array().unwrap() {
            let [shown, told] = [0, 1].map(|i| pair[i].as_f64().unwrap());
            assert!((shown - told).abs() <= 1e-5 * told.abs().max(1.0), "{name}: {pairs}");
        }
        let text = browser.value("document.getElementById('open-text').textContent").as_str().unwrap().to_owned();
        assert!(text.starts_with(name), "{text}");
    }
    // Undo comes back to the file before.
    let before = picture(&mut browser);
    browser.value("window.vr.send({ kind: 'undo' }); window.vr.send({ kind: 'undo' })");
    browser.wait("document.getElementById('title').textContent === 'cells.vtk'");
    settled(&mut browser, before);
    assert_truth(&mut browser);
    // A path that leads out is refused in words, and changes nothing.
    browser.value("(() => { document.getElementById('open-path').value = '../x'; document.getElementById('open-form').requestSubmit(); })()");
    browser.wait("document.getElementById('toast').textContent.includes('--folder')");
    assert_eq!(title(&mut browser), "cells.vtk");
    // A file that is chosen is sent in pieces.
    let document = browser.call("DOM.getDocument", json!({}))["root"]["nodeId"].clone();
    let input =
        browser.call("DOM.querySelector", json!({"nodeId": document, "selector": "#open-files"}))["nodeId"].clone();
    let path = folder.path().join("grid.nrrd");
    browser.call("DOM.setFileInputFiles", json!({"nodeId": input, "files": [path]}));
    browser.wait("document.getElementById('title').textContent === 'grid.nrrd'");
    rest(&mut browser);
    // One that is dropped, too; rubbish is said.
    let drop = |browser: &mut Browser, name: &str, text: &str| {
        browser.value(&format!(
            "(() => {{ const t = new DataTransfer(); t.items.add(new File([{text:?}], {name:?})); \
             window.dispatchEvent(new DragEvent('drop', {{ dataTransfer: t, cancelable: true }})); }})()"
        ));
    };
    drop(&mut browser, "dropped.csv", "x,y,z,h,Temperature\n0,0,0,1,1\n1,1,1,1,2\n");
    browser.wait("document.getElementById('title').textContent === 'dropped.csv'");
    rest(&mut browser);
    drop(&mut browser, "rubbish.nrrd", "no volume");
    browser.wait("document.getElementById('toast').textContent.startsWith('rubbish.nrrd: ')");
    assert_eq!(title(&mut browser), "dropped.csv");
    browser.value("document.getElementById('section-open').open = true");
    screenshots(&running, &mut browser, "open", |browser| {
        browser.value("document.getElementById('panel').inert && document.getElementById('panel-toggle').click(); document.getElementById('section-open').open = true; document.getElementById('section-open').scrollIntoView()");
    });
    browser.complaints.retain(|complaint| !complaint.contains("403") && !complaint.contains("422"));
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}
