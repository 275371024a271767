//! Opening of another file: what is kept, what is taken back, and what is refused.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec3;
use serde_json::Value;
use tungstenite::Message;
use vr_core::field::FunctionField;
use vr_core::{ControlPoint, Volume};
use vr_io::ShadingSection;
use vr_view::session::{Edit, EditError, Export, Setting, Stage};
use vr_view::upload::MAX_PIECE;

use crate::common::{
    Answer, Client, PATIENCE, Running, Watched, document, drawn_anew, kinds, nrrd, of_volume, read, subject_of,
};

fn words(answer: &Answer) -> String {
    String::from_utf8(answer.body.clone()).unwrap()
}

fn kind(name: &str) -> Volume {
    kinds().into_iter().find(|(kind, _)| *kind == name).unwrap().1
}

#[test]
fn curve_light_and_camera_are_kept_and_undo_comes_back() {
    let mut d = of_volume(kind("grid"), [40, 30]);
    let points = vec![ControlPoint::new(-1.0, [0.2, 0.4, 0.6], 0.0), ControlPoint::new(5.0, [1.0, 0.5, 0.0], 0.3)];
    let shading = ShadingSection { ambient: 0.31, ..ShadingSection::default() };
    for edit in [
        Edit::Transfer { points: points.clone() },
        Edit::Shading { shading: shading.clone() },
        Edit::Orbit { right: 20.0, up: 5.0 },
        Edit::Crop { corners: Some([[1.0; 3], [9.0; 3]]) },
    ] {
        d.apply(&edit).unwrap();
    }
    let (before, camera) = (d.file(), d.view().camera);
    // A volume in the same place: all but the crop box is as it was.
    d.open(Arc::new(subject_of(kind("grid"), [40, 30]))).unwrap();
    let file = d.file();
    assert_eq!((&file.transfer, &file.shading), (&before.transfer, &before.shading));
    assert!(d.view().camera == camera && file.clip.crop.is_none() && d.volume_revision() == 1);
    assert_eq!(d.scene().transfer.points(), &points[..]);
    d.apply(&Edit::Undo).unwrap();
    assert!(d.file() == before && d.view().camera == camera && d.volume_revision() == 2);
    d.apply(&Edit::Redo).unwrap();
    assert_eq!(d.file(), file);
    // One elsewhere is seen from the same side; undo brings the camera back, too.
    d.open(Arc::new(subject_of(kind("points"), [40, 30]))).unwrap();
    let way = |c: &vr_core::Camera| (c.target - c.eye).normalize();
    let now = d.view().camera;
    assert!(way(&now).distance(way(&camera)) < 1e-9 && now != camera);
    assert_eq!(d.scene().transfer.points(), &points[..]);
    assert!(matches!(d.scene().volume, Volume::Points(_)));
    d.apply(&Edit::Undo).unwrap();
    assert_eq!(d.view().camera, camera);
    // A third volume: one before it is kept in memory, and none further back.
    d.apply(&Edit::Redo).unwrap();
    let first = Arc::downgrade(d.subject());
    d.open(Arc::new(subject_of(kind("adaptive grid"), [40, 30]))).unwrap();
    d.open(Arc::new(subject_of(kind("mesh of cells"), [40, 30]))).unwrap();
    d.apply(&Edit::Undo).unwrap();
    assert!(matches!(d.scene().volume, Volume::Amr(_)));
    assert!(matches!(d.apply(&Edit::Undo), Err(EditError::NoHistory(_))));
    assert!(first.upgrade().is_none(), "the volume is gone from memory");
    // A curve under which nothing would be seen gives way to the volume's own look.
    let beyond = vec![ControlPoint::new(1e6, [1.0; 3], 0.0), ControlPoint::new(2e6, [1.0; 3], 0.5)];
    d.apply(&Edit::Transfer { points: beyond.clone() }).unwrap();
    d.open(Arc::new(subject_of(kind("grid"), [40, 30]))).unwrap();
    assert_ne!(d.scene().transfer.points(), &beyond[..]);
}

#[test]
fn pictures_after_opening_are_those_of_the_saved_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str, factor: f32| {
        let path = folder.path().join(name);
        std::fs::write(&path, nrrd(factor)).unwrap();
        path
    };
    let (a, b) = (path("a.nrrd", 1.0), path("b.nrrd", 0.5));
    let watched = Watched::of(document("fog", 8, [48, 40]));
    let check = |number: u64| {
        watched.session.apply(1, number, &Edit::Orbit { right: 1.0, up: 0.0 }).unwrap();
        let shown = watched.picture(Stage::Proven, number);
        let text = String::from_utf8(watched.session.export(Export::Scene).unwrap()).unwrap();
        assert!(drawn_anew(&text).1 == shown.rgba, "{text}");
        assert!(shown.rgba.chunks(4).any(|p| p != &shown.rgba[..4]), "it shows something");
        shown.rgba.clone()
    };
    check(1);
    watched.session.open(read(&a).unwrap()).unwrap();
    watched.session.apply(1, 2, &Edit::AutomaticLook).unwrap();
    let of_a = check(3);
    watched.session.open(read(&b).unwrap()).unwrap();
    let of_b = check(4);
    assert_ne!(of_a, of_b);
    assert_eq!(watched.session.opened().volume, 2);
}

/// The words that a client is told until one of a kind.
fn told(client: &mut Client, kind: &str) -> Value {
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        if let Message::Text(text) = client.read().unwrap() {
            let word: Value = serde_json::from_str(&text).unwrap();
            if word["kind"] == kind {
                return word;
            }
        }
    }
    panic!("{kind} is told in time");
}

#[test]
fn files_below_the_folder_are_opened_by_their_path_and_no_others() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("volumes");
    std::fs::create_dir_all(folder.join("more")).unwrap();
    for name in ["volumes/a.nrrd", "volumes/more/b c.nrrd", "secret.nrrd", "volumes/.hidden"] {
        std::fs::write(outer.path().join(name), nrrd(1.0)).unwrap();
    }
    std::fs::write(folder.join("broken.nrrd"), b"NRRD0005\ntype: float\n\n").unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(outer.path().join("secret.nrrd"), folder.join("link.nrrd")).unwrap();
    let running = Running::opening(document("fog", 8, [32, 24]), Some(&folder), 1 << 20);
    let listing: Value = serde_json::from_slice(&running.get("files").body).unwrap();
    assert_eq!(listing["files"], serde_json::json!(["a.nrrd", "broken.nrrd", "more/b c.nrrd"]));
    let mut client = running.connect();
    told(&mut client, "opened");
    assert_eq!(running.post("open?path=more/b%20c.nrrd", &[]).status, 204);
    let opened = told(&mut client, "opened");
    assert_eq!((&opened["opened"]["title"], &opened["opened"]["volume"]), (&"more/b c.nrrd".into(), &1.into()));
    let secret = outer.path().join("secret.nrrd").display().to_string();
    for wrong in ["../secret.nrrd", "more/../../secret.nrrd", &secret, "/etc/passwd", "link.nrrd", "", ".", "none.nrrd"]
    {
        let answer = running.post(&format!("open?path={wrong}"), &[]);
        assert!(answer.status == 403 && words(&answer).contains("--folder"), "{wrong}: {}", words(&answer));
        assert!(wrong == secret || !words(&answer).contains(&outer.path().display().to_string()));
    }
    // A header may name other files: what lies outside is not shown.
    for place in ["../secret.raw", &outer.path().join("secret.raw").display().to_string()] {
        std::fs::write(outer.path().join("secret.raw"), [1; 8]).unwrap();
        let header = format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: {place}\n");
        std::fs::write(folder.join("leads.nhdr"), header).unwrap();
        let answer = running.post("open?path=leads.nhdr", &[]);
        assert!(answer.status == 403 && words(&answer).contains("not beside it"), "{place}: {}", words(&answer));
    }
    // Messages about files that cannot be read leave the folder's own place out.
    let answer = running.post("open?path=broken.nrrd", &[]);
    assert!(answer.status == 422 && words(&answer).starts_with("broken.nrrd"), "{}", words(&answer));
    assert!(!words(&answer).contains(&outer.path().display().to_string()));
    // Another page cannot steer it: without its origin, or with another.
    for origin in ["", "\nOrigin: http://evil.example"] {
        let lines = format!("POST /{}/open?path=a.nrrd HTTP/1.1\nHost: {}{origin}", running.token, running.address);
        assert_eq!(running.request(&lines).status, 403);
    }
    assert_eq!(running.get("open?path=a.nrrd").status, 405);
    running.end();
    // Without a folder no path is, and without leave nothing is.
    let running = Running::opening(document("fog", 8, [32, 24]), None, 1 << 20);
    let answer = running.post("open?path=a.nrrd", &[]);
    assert!(answer.status == 403 && words(&answer).contains("no folder was named"));
    running.end();
    let running = Running::new(document("fog", 8, [32, 24]), true);
    assert_eq!((running.post("open?path=a.nrrd", &[]).status, running.post("upload?bytes=1", &[]).status), (403, 403));
    assert!(running.get("files").body.starts_with(br#"{"opens":false"#));
    running.end();
}

/// Begins an upload; returns its number.
fn begin(running: &Running, bytes: usize) -> String {
    let answer = running.post(&format!("upload?bytes={bytes}"), &[]);
    assert_eq!(answer.status, 200, "{}", words(&answer));
    let begun: Value = serde_json::from_slice(&answer.body).unwrap();
    begun["id"].as_str().unwrap().to_owned()
}

/// Folders of this process's uploads: others on this machine come and go.
fn folders() -> usize {
    let own = format!("vr-view-{}-", std::process::id());
    let names = std::fs::read_dir(std::env::temp_dir()).unwrap().flatten().map(|entry| entry.file_name());
    names.filter(|name| name.to_string_lossy().starts_with(&own)).count()
}

#[test]
fn files_are_sent_in_pieces_and_everything_else_is_refused_in_words() {
    let before = folders();
    let running = Running::opening(document("fog", 8, [32, 24]), None, 100_000);
    let mut client = running.connect();
    told(&mut client, "opened");
    let file = nrrd(1.0);
    let id = begin(&running, file.len());
    // One at a time.
    let second = running.post("upload?bytes=5", &[]);
    assert!(second.status == 409 && words(&second).contains("another page"), "{}", words(&second));
    let (first, rest) = file.split_at(1000);
    let piece = |name: &str, offset: usize, bytes: &[u8]| {
        running.post(&format!("upload/{id}?name={name}&offset={offset}"), bytes)
    };
    assert_eq!(piece("scan.nrrd", 0, first).status, 204);
    for name in ["../scan.nrrd", "..", "%2Fetc%2Fpasswd", "a%5Cb", "", "%00"] {
        let refused = piece(name, 0, b"x");
        assert!(refused.status == 422 && words(&refused).starts_with("name: "), "{name}: {}", words(&refused));
    }
    assert_eq!(piece("scan.nrrd", 999, rest).status, 422, "a piece in another place");
    assert_eq!(piece("scan.nrrd", 1000, &[rest, b"x"].concat()).status, 413, "more than was announced");
    assert_eq!(piece("scan.nrrd", 1000, &vec![0; MAX_PIECE + 1]).status, 413, "a piece that is too large");
    assert_eq!(running.post(&format!("upload/{}?name=a&offset=0", "0".repeat(32)), b"x").status, 404);
    assert_eq!(piece("scan.nrrd", 1000, rest).status, 204);
    assert_eq!(running.post(&format!("upload/{id}/open?name=..%2Fscan.nrrd"), &[]).status, 422);
    assert_eq!(folders(), before, "what is over leaves nothing");
    // And again, this time to the end.
    let id = begin(&running, file.len());
    assert_eq!(running.post(&format!("upload/{id}?name=scan.nrrd&offset=0"), &file).status, 204);
    let opened = running.post(&format!("upload/{id}/open?name=scan.nrrd"), &[]);
    assert_eq!(opened.status, 204, "{}", words(&opened));
    assert_eq!(told(&mut client, "opened")["opened"]["title"], "scan.nrrd");
    let scene = words(&running.get("save/scene.toml"));
    assert!(scene.contains("scan.nrrd\"") && !scene.contains("vr-view-"), "{scene}");
    // Too large, and nonsense: nothing is changed.
    let large = running.post("upload?bytes=100001", &[]);
    assert!(large.status == 413 && words(&large).contains("100 kB at most"), "{}", words(&large));
    for nonsense in [&b"NRRD0005\ntype: lion\n\n"[..], &[0xff; 3000], b""] {
        let id = begin(&running, nonsense.len());
        assert_eq!(running.post(&format!("upload/{id}?name=x.nrrd&offset=0"), nonsense).status, 204);
        let refused = running.post(&format!("upload/{id}/open?name=x.nrrd"), &[]);
        assert!(refused.status == 422 && !words(&refused).contains("vr-view-"), "{}", words(&refused));
    }
    assert_eq!(words(&running.get("save/scene.toml")), scene);
    // One that is given up.
    let id = begin(&running, 10);
    let (token, address) = (&running.token, &running.address);
    let lines = format!("DELETE /{token}/upload/{id} HTTP/1.1\nHost: {address}\nOrigin: http://{address}");
    assert_eq!(running.request(&lines).status, 204);
    assert_eq!(folders(), before, "no file of a page is left");
    running.end();
}

#[test]
fn a_survey_holds_up_none_of_the_other_requests() {
    // A function whose look takes seconds to find.
    let slow = |p: DVec3| {
        std::thread::sleep(Duration::from_micros(60));
        p.length()
    };
    let field = FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), slow).unwrap().with_value_range((0.0, 1.8));
    let document = of_volume(field.with_spacing(0.5).unwrap().into(), [4, 4]);
    let running = Running::new(document, true);
    let mut client = running.connect();
    client.send(Message::text(r#"{"number": 1, "edit": {"kind": "preset", "name": "inferno"}}"#)).unwrap();
    let start = Instant::now();
    let mut worst = Duration::ZERO;
    while start.elapsed() < Duration::from_millis(700) {
        let asked = Instant::now();
        assert_eq!(running.get("style.css").status, 200);
        worst = worst.max(asked.elapsed());
    }
    assert!(worst < Duration::from_millis(400), "{worst:?}");
    let end = Instant::now() + PATIENCE;
    while running.get("save/scene.toml").body.is_empty() {
        assert!(Instant::now() < end);
    }
    running.end();
}

#[test]
fn the_heaviest_sample_is_what_is_seen() {
    // A ball in fog: the value falls from 1 in the middle; opaque from 0.5 on, thin fog below.
    let ball = FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), |p| 1.0 - p.length()).unwrap();
    let volume = Volume::from(ball.with_value_range((-1.0, 1.0)).with_spacing(0.02).unwrap());
    let mut d = of_volume(volume, [101, 101]);
    let wall = |value: f64, opacity: f64| ControlPoint::new(value, [1.0; 3], opacity);
    let points = vec![wall(-1.0, 0.01), wall(0.499, 0.01), wall(0.5, 1.0), wall(1.0, 1.0)];
    d.apply(&Edit::Transfer { points }).unwrap();
    d.apply(&Edit::Side { side: vr_view::session::Side::Front }).unwrap();
    let (eye, height) = match d.view().camera {
        vr_core::Camera { eye, projection: vr_core::Projection::Orthographic { height }, .. } => (eye, height),
        other => panic!("{other:?}"),
    };
    let watched = Watched::of(d);
    for [x, y] in [[0.0, 0.0], [0.2, 0.1], [-0.3, 0.25]] {
        let pick = watched.session.pick([(x - eye.x) / height, (y - eye.y) / height]).unwrap().unwrap();
        // The surface of radius 0.5, to a sample's distance.
        let z = f64::sqrt(0.25 - x * x - y * y);
        let place = DVec3::new(x, y, z);
        assert!(pick.at.distance(place) < 0.03, "{pick:?} {place}");
        assert!((pick.value - 0.5).abs() < 0.03 && pick.share > 0.5, "{pick:?}");
    }
    // Beside the volume is nothing; a crop box in front of the middle takes the surface away.
    assert_eq!(watched.session.pick([5.0, 0.0]).unwrap(), None);
    let corners = Some([[-1.0, -1.0, -1.0], [1.0, 1.0, 0.2]]);
    watched.session.apply(1, 1, &Edit::Crop { corners }).unwrap();
    let pick = watched.session.pick([-eye.x / height, -eye.y / height]).unwrap().unwrap();
    assert!((pick.at.z - 0.2).abs() < 0.03, "{pick:?}");
    assert!(watched.session.pick([f64::NAN, 0.0]).is_err());
}

#[test]
fn a_pixel_of_the_second_picture_is_asked_for_by_its_setting() {
    let watched = Watched::of(document("blobs", 16, [40, 30]));
    let setting = Setting { renderer: "shearwarp".to_owned(), quality: None };
    let [own, second] = [watched.session.ray([20, 15]).unwrap(), watched.session.ray_of([20, 15], &setting).unwrap()];
    assert_eq!((own.renderer, second.renderer, &own.exact), ("raycast", "shearwarp", &second.exact));
    // It is the pixel of the second picture, to the byte.
    let picture = watched.session.second(&setting).unwrap();
    let at = 4 * (15 * 40 + 20);
    let near = (0..3).all(|c| picture.rgba[at + c].abs_diff(second.screen[0][c]) <= 1);
    assert!(near, "{:?} {:?}", &picture.rgba[at..at + 3], second.screen);
    let running = Running::new(document("blobs", 16, [40, 30]), true);
    let plot: Value = serde_json::from_slice(&running.get("truth/ray?x=20&y=15&renderer=shearwarp").body).unwrap();
    assert_eq!(plot["renderer"], "shearwarp");
    let refused = running.get("truth/ray?x=20&y=15&renderer=oil");
    assert!(refused.status == 422 && words(&refused).contains("oil"));
    let pick: Value = serde_json::from_slice(&running.get("pick?x=0&y=0").body).unwrap();
    assert!(pick.is_null() || pick["value"].is_number());
    assert_eq!(running.get("pick?x=0").status, 400);
    running.end();
}
