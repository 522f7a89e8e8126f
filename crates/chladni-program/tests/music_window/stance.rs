//! Which way a shape stands, where that is corrected.

use super::*;

fn choose(window: &mut Window, entry: &str) {
    click(window, "stance");
    window.run_steps(2);
    click(window, entry);
}

#[test]
fn a_shape_that_is_turned_stands_so_in_its_show_and_another_by_itself() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let answers = Answers::default();
    let (chooser, files) = (Box::new(answers.clone()), ball_and_song(folder.path()).to_vec());
    let mut window = enter(Opening { folders: folders(folder.path()), chooser, files, ..Opening::default() });
    let stands = |w: &Window| control(w, "stance").accesskit_node().label().unwrap_or_default();
    click(&mut window, "drawer/look");
    let found = stands(&window);
    choose(&mut window, "stance/-x");
    wait(&mut window, "another side above", |w| stands(w).contains("up -x"));
    assert!(!found.contains("up -x"), "{found}");
    let show = saved_show(&mut window, &answers, &path("turned.toml"));
    assert!(show.stands.is_some_and(|stands| stands.to_string().starts_with("up -x")), "{:?}", show.stands);

    answers.add("sample:bell");
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    wait(&mut window, "the bell", |w| stands(w).contains("up y, front z"));
    assert_eq!(saved_show(&mut window, &answers, &path("bell.toml")).stands, None);

    answers.add(path("turned.toml"));
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    wait(&mut window, "the show", |w| stands(w).contains("up -x"));
    choose(&mut window, "stance/estimated");
    wait(&mut window, "the estimate", |w| stands(w) == found);
    assert_eq!(saved_show(&mut window, &answers, &path("estimated.toml")).stands, None);
}
