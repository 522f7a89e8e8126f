//! Media keys, on a bus of their own (Linux).

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use zbus::blocking::{Proxy, connection, proxy};
use zbus::proxy::CacheProperties;

use super::*;

/// Set where a test runs on a bus of its own.
const OWN_BUS: &str = "CHLADNI_TEST_OWN_BUS";

/// Runs a test again in a process whose session bus is its own: a window looks for that in the environment. False where
/// it does run there.
#[allow(clippy::print_stdout, reason = "what is skipped is said")]
fn ran_on_own_bus(test: &str) -> bool {
    if std::env::var_os(OWN_BUS).is_some() {
        return false;
    }
    let daemon = Command::new("dbus-daemon")
        .args(["--session", "--nofork", "--print-address=1"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let Ok(mut daemon) = daemon else {
        println!("skipped: no dbus-daemon");
        return true;
    };
    let mut address = String::new();
    BufReader::new(daemon.stdout.take().unwrap()).read_line(&mut address).unwrap();
    let ran = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture"])
        .env("DBUS_SESSION_BUS_ADDRESS", address.trim())
        .env(OWN_BUS, "1")
        .output()
        .unwrap();
    let _ = daemon.kill();
    let _ = daemon.wait();
    let said = String::from_utf8_lossy(&ran.stdout);
    assert!(said.contains("1 passed"), "{said}{}", String::from_utf8_lossy(&ran.stderr));
    true
}

#[test]
fn they_act_while_another_room_is_shown() {
    if ran_on_own_bus("media_keys::they_act_while_another_room_is_shown") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let files = ball_and_song(folder.path()).to_vec();
    let mut window = enter(Opening { folders: folders(folder.path()), files, ..Opening::default() });
    let client = connection::Builder::session().unwrap().build().unwrap();
    // A proxy that keeps properties remembers, too, that nobody was there at first.
    let player = proxy::Builder::<Proxy<'_>>::new(&client)
        .destination("org.mpris.MediaPlayer2.chladni")
        .and_then(|proxy| proxy.path("/org/mpris/MediaPlayer2")?.interface("org.mpris.MediaPlayer2.Player"))
        .and_then(|proxy| proxy.cache_properties(CacheProperties::No).build())
        .unwrap();
    let is = |state: &str| player.get_property::<String>("PlaybackStatus").is_ok_and(|seen| seen == state);
    wait(&mut window, "the song", |_| is("Playing"));
    window.get_by_role_and_label(Role::Button, "Chladni").click_accesskit();
    wait(&mut window, "the start screen", |w| is_there(w, "room/0"));
    click(&mut window, "room/0");
    wait(&mut window, "the other room", |w| !is_there(w, "room/0"));
    player.call_method("Pause", &()).unwrap();
    wait(&mut window, "the pause", |_| is("Paused"));
}
